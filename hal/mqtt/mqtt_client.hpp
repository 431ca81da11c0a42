// SPDX-License-Identifier: Apache-2.0
// One connection to an MQTT 5 broker: QoS 0, a clean start each time, nothing retained. It is driven from outside, as
// its owner has other things to wait for as well, and never waits itself. A lost connection is begun anew by the owner.
// One thread. The first client of a process makes it ignore SIGPIPE.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal {

struct MqttSettings {
  std::string host;  ///< IPv4 or IPv6, as numbers: a static program has no names
  std::uint16_t port = 1883;
  std::string client_id;  ///< another client with the same one is thrown out by the broker
  std::string user;       ///< empty: none, and no password
  std::string password;
  std::vector<std::string> subscriptions;
  int keepalive_s = 10;  ///< 5 to 65535; a broker that is silent is given up after twice that at most
  std::uint32_t most_packet_bytes = 64 * 1024;  ///< larger ones the broker is told not to send
  std::size_t send_buffer_bytes = 64 * 1024;    ///< of the kernel: what waits there is late, and can no more be dropped
};

class MqttClient {
 public:
  /// Valid until it returns. It must not call the client.
  using OnMessage = std::function<void(std::string_view topic, std::span<const std::uint8_t> payload)>;

  /// Whether this program was built with libmosquitto; see scripts/static_libs.
  [[nodiscard]] static bool is_built_in();
  /// Connects nothing yet. Errors: unsupported (not built in), bad_usage (what no broker could be asked for).
  [[nodiscard]] static Result<std::unique_ptr<MqttClient>> make(const MqttSettings& settings, OnMessage on_message);
  virtual ~MqttClient() = default;

  /// Begins to connect, whatever was before. False: not even that; last_fault() says why.
  virtual bool connect() = 0;
  /// Says goodbye, if it can at once, and closes.
  virtual void disconnect() = 0;
  /// To be waited for: readable, and writable as well if wants_write(). -1: no connection.
  [[nodiscard]] virtual int socket() const = 0;
  /// What was published last has not all been taken by the kernel: more would wait in memory.
  [[nodiscard]] virtual bool wants_write() const = 0;
  /// Reads, writes and keeps alive; at least once a second. False: the connection is lost; last_fault() says why.
  virtual bool serve(bool is_readable, bool is_writable) = 0;
  /// The broker has taken us, and our subscriptions.
  [[nodiscard]] virtual bool is_ready() const = 0;
  /// How many topics may be published under a number, 1 and up.
  [[nodiscard]] virtual std::uint16_t most_aliases() const = 0;
  /// `alias`: 0, or the number that this topic gets; an empty topic means the one that has got it on this connection.
  /// A broker that could not pass the message on for `expiry_s` drops it. False: not sent.
  virtual bool publish(const std::string& topic, std::uint16_t alias, std::span<const std::uint8_t> payload,
                       std::uint32_t expiry_s) = 0;
  [[nodiscard]] virtual const std::string& last_fault() const = 0;
};

}  // namespace g3d::hal
