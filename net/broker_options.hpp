// SPDX-License-Identifier: Apache-2.0
// What a board file says about a broker, made into the options of a port. The login stands in a file of its own, that
// nobody else may read:
//
//   user warehouse-2
//   password much longer than this
//
// Cold paths only.
#pragma once

#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "net/layer_id.hpp"
#include "net/mqtt_port.hpp"

namespace g3d::net {

struct BrokerWords {
  std::string address;         ///< "192.0.2.7:1883"
  std::string topic;           ///< root of the topics; the same at all sites
  std::string login = "none";  ///< the file, or "none"
};

struct BrokerLogin {
  std::string user, password;
};

/// Errors: malformed (address, topic); those of read_broker_login().
[[nodiscard]] hal::Result<MqttPortOptions> broker_options(const BrokerWords& words, RobotId robot);

/// Errors: not_found, no_permission (others may read it), too_large, io_error; malformed, as parse_broker_login().
[[nodiscard]] hal::Result<BrokerLogin> read_broker_login(const std::string& path);
/// Lines that are empty or begin with '#' say nothing. Errors: malformed; they name `name` and the line, and show
/// nothing of a password.
[[nodiscard]] hal::Result<BrokerLogin> parse_broker_login(std::string_view text, const std::string& name);

}  // namespace g3d::net
