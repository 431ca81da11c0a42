// SPDX-License-Identifier: Apache-2.0
// Listens at the base's end of a pseudo-terminal: the packets that a driver or guard sends, each with the time at which
// it could be read, by CLOCK_MONOTONIC.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/clock.hpp"

namespace g3d::test {

struct SentPacket {
  hal::TimeNs t_ns = 0;
  std::vector<std::uint8_t> bytes;  ///< from AA to the checksum
  [[nodiscard]] bool is_zero_speed() const;
  /// Has a base control block, with or without others.
  [[nodiscard]] bool is_base_control() const;
};

class CommandTap {
 public:
  /// `fd` is the far end, non-blocking; stays the caller's.
  explicit CommandTap(int fd) : fd_(fd) {}

  /// Waits until one packet more has come; false after `timeout_ns`.
  [[nodiscard]] bool next(SentPacket& packet, hal::TimeNs timeout_ns);
  /// The next zero-speed packet, all others thrown away; 0 if none came in time.
  [[nodiscard]] hal::TimeNs wait_for_zero(hal::TimeNs timeout_ns);
  /// The same for a base control with motion.
  [[nodiscard]] hal::TimeNs wait_for_motion(hal::TimeNs timeout_ns);
  /// Everything that comes within `for_ns`.
  [[nodiscard]] std::vector<SentPacket> listen(hal::TimeNs for_ns);
  /// Throws away what is there.
  void drain();

 private:
  template <typename Wanted>
  hal::TimeNs wait_for(hal::TimeNs timeout_ns, Wanted&& wanted);
  [[nodiscard]] bool take(SentPacket& packet);

  const int fd_;
  const hal::RealClock clock_;
  std::vector<std::uint8_t> pending_;
};

}  // namespace g3d::test
