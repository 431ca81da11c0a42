// SPDX-License-Identifier: Apache-2.0
// A real MQTT broker (Debian's mosquitto) on a free port of this machine, which a test may kill and start again.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::test {

class BrokerProcess {
 public:
  /// Why there can be none, for people; empty: mosquitto is installed, and libmosquitto built in.
  [[nodiscard]] static std::string what_is_missing();

  /// `extra`: lines of its configuration. Nothing runs yet.
  explicit BrokerProcess(const std::string& extra = "allow_anonymous true\n");
  /// Until it takes connections. Throws if it does not.
  void start();
  /// At once, as a power cut does.
  void kill() { program_.reset(); }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const TempFolder& folder() const { return folder_; }
  [[nodiscard]] pid_t pid() const { return program_->pid(); }

 private:
  TempFolder folder_;
  std::uint16_t port_ = 0;
  std::unique_ptr<Program> program_;
};

}  // namespace g3d::test
