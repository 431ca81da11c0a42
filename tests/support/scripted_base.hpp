// SPDX-License-Identifier: Apache-2.0
// The base's end of a pseudo-terminal in real time: a thread that sends a packet each 20 ms, as a Kobuki does unasked,
// with the flags that a test sets. It drives as if everything it is told happened at once.
#pragma once

#include <atomic>
#include <thread>

#include "hal/kobuki/feedback.hpp"

namespace g3d::test {

class ScriptedBase {
 public:
  /// `fd` is the far end; stays the caller's.
  explicit ScriptedBase(int fd);
  ~ScriptedBase();
  ScriptedBase(const ScriptedBase&) = delete;
  ScriptedBase& operator=(const ScriptedBase&) = delete;

  /// Of the packets from now on: bumper, cliff, wheel drop.
  void set_flags(std::uint8_t bumper, std::uint8_t cliff, std::uint8_t wheel_drop);
  /// Sends no packets.
  void set_silent(bool silent) { silent_.store(silent); }
  /// Ticks of both wheels in each packet.
  void set_ticks(int ticks) { ticks_.store(ticks); }
  /// When the first packet with the present flags began to be written; 0 before.
  [[nodiscard]] hal::TimeNs flags_sent_ns() const { return flags_sent_ns_.load(); }
  /// When the last packet began to be written.
  [[nodiscard]] hal::TimeNs last_sent_ns() const { return last_sent_ns_.load(); }

 private:
  void run();

  const int fd_;
  std::atomic<std::uint32_t> flags_{0};
  std::atomic<bool> silent_{false}, ending_{false};
  std::atomic<int> ticks_{0};
  std::atomic<hal::TimeNs> flags_sent_ns_{0}, last_sent_ns_{0};
  std::thread thread_;
};

}  // namespace g3d::test
