// SPDX-License-Identifier: Apache-2.0
// The machine's hardware watchdog (/dev/watchdog): unless it is fed in time it resets the machine. Armed by opening,
// disarmed by the magic close alone, so that a program that dies leaves it running.
#pragma once

#include <memory>
#include <string>

#include "hal/result.hpp"

namespace g3d::hal {

class Watchdog {
 public:
  virtual ~Watchdog() = default;
  /// False: the device refused it. May wait for the device.
  [[nodiscard]] virtual bool feed() = 0;
  /// A good end: the machine goes on without being reset.
  virtual void disarm() = 0;
};

class LinuxWatchdog final : public Watchdog {
 public:
  /// Opens and so arms it, with the timeout nearest to `timeout_s` that it grants. Errors: not_found, no_permission,
  /// no_capacity (another program has it), unsupported (no watchdog), io_error.
  [[nodiscard]] static Result<std::unique_ptr<LinuxWatchdog>> open(const std::string& path, int timeout_s);
  /// Of a descriptor that is a watchdog already, or a test's file; owns it.
  LinuxWatchdog(int fd, int timeout_s, std::string name);
  /// Without disarm() it stays armed.
  ~LinuxWatchdog() override;
  LinuxWatchdog(const LinuxWatchdog&) = delete;
  LinuxWatchdog& operator=(const LinuxWatchdog&) = delete;

  [[nodiscard]] bool feed() override;
  void disarm() override;
  /// What was granted.
  [[nodiscard]] int timeout_s() const { return timeout_s_; }
  /// What the driver calls itself.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Whether this start follows a reset by the watchdog, as far as its driver knows.
  [[nodiscard]] bool has_bitten() const { return has_bitten_; }

 private:
  int fd_;
  int timeout_s_;
  std::string name_;
  bool has_bitten_ = false;
};

}  // namespace g3d::hal
