// SPDX-License-Identifier: Apache-2.0
// Tells whoever started this program how it is: systemd (Type=notify), or our own first process, which speaks the same:
// one datagram to the socket that $NOTIFY_SOCKET names. Plain C++, no libsystemd. Where nobody supervises, every call
// does nothing.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "hal/messages.hpp"

namespace g3d::hal {

class ServiceNotify {
 public:
  static constexpr std::size_t kMostStatus_bytes = 400;

  /// NOTIFY_SOCKET, WATCHDOG_USEC, WATCHDOG_PID: as systemd sets them. What is not understood is as if not there.
  ServiceNotify() : ServiceNotify(variable("NOTIFY_SOCKET"), variable("WATCHDOG_USEC"), variable("WATCHDOG_PID")) {}
  /// `address`: a path, or @NAME for one without a file. `watchdog_us`: decimal; empty: no watchdog. `watchdog_pid`:
  /// whom that is meant for; empty: this process.
  ServiceNotify(std::string_view address, std::string_view watchdog_us, std::string_view watchdog_pid = {});
  ~ServiceNotify();
  ServiceNotify(const ServiceNotify&) = delete;
  ServiceNotify& operator=(const ServiceNotify&) = delete;

  [[nodiscard]] bool is_supervised() const { return fd_ >= 0; }
  /// alive() is due at least so often, half of what ends in a restart; 0: nobody waits for it.
  [[nodiscard]] TimeNs alive_period_ns() const { return alive_period_ns_; }

  /// Any thread; never blocks, never allocates. False: nobody supervises, or the datagram was not taken (counted).
  bool ready() { return send("READY=1"); }
  bool alive() { return send("WATCHDOG=1"); }
  bool stopping() { return send("STOPPING=1"); }
  /// From now on alive() may be so late; for work that takes long and makes no other sign. Nothing without a watchdog.
  bool allow_silence(TimeNs silence_ns);
  /// For people; cut after kMostStatus_bytes, line ends and the like become spaces.
  bool status(std::string_view text);

  [[nodiscard]] std::uint64_t sent() const { return sent_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }

 private:
  static std::string_view variable(const char* name);
  bool send(std::string_view text);

  int fd_ = -1;  ///< connected
  TimeNs alive_period_ns_ = 0;
  std::atomic<std::uint64_t> sent_{0}, lost_{0};
};

}  // namespace g3d::hal
