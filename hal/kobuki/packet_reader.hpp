// SPDX-License-Identifier: Apache-2.0
// The bytes of a Kobuki's line -> feedback. A packet counts only if its whole frame is right, its values are possible
// and it can follow the packet before. What a corrupted frame that passes all that can still do is bounded:
//  * odometry moves no further than the gates of packet_gates.hpp allow, and the next good packet takes it back, since
//    encoders and gyro angle are absolute;
//  * a safety flag (bumper, cliff, wheel drop, over-current) is set by one packet but cleared by two that agree, one
//    after the other: such a frame can stop the robot, never release it;
//  * after a restart of the base, a long silence or a corrupted reference, two packets that agree with each other
//    become the new reference; the first of them is lost. A base that repeats one packet is a silent base.
#pragma once

#include <optional>
#include <utility>

#include "hal/kobuki/feedback_codec.hpp"

namespace g3d::hal::kobuki {

/// One thread. Allocates nothing.
class PacketReader {
 public:
  PacketReader();
  /// Calls `on_feedback(const Feedback&)` for each packet that `bytes` complete, stamped `received_ns`.
  template <typename OnFeedback>
  void feed(std::span<const std::uint8_t> bytes, TimeNs received_ns, OnFeedback&& on_feedback) {
    while (!bytes.empty()) {
      bytes = bytes.subspan(scanner_.append(bytes));
      Feedback feedback;
      while (next(received_ns, feedback)) on_feedback(std::as_const(feedback));
    }
  }

  [[nodiscard]] const RejectCounts& rejects() const { return rejects_; }
  /// What the base has answered so far.
  [[nodiscard]] const DeviceInfo& info() const { return info_; }
  [[nodiscard]] const std::optional<ControllerGains>& gains() const { return gains_; }
  /// How often a packet that could not follow the one before became the new reference.
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }
  /// The line was down: what is half read will not be finished, and another base may be at the other end, whose
  /// answers must be asked for anew. Safety flags stay until two packets clear them.
  void line_was_lost();

 private:
  [[nodiscard]] bool next(TimeNs received_ns, Feedback& feedback);
  [[nodiscard]] bool believe(const Feedback& feedback);
  void hold_flags(Feedback& feedback);

  FrameScanner scanner_;
  RejectCounts rejects_;
  DeviceInfo info_;
  std::optional<ControllerGains> gains_;
  std::optional<Feedback> last_;       // accepted, flags as received
  std::optional<Feedback> candidate_;  // could not follow last_, nothing accepted since
  std::uint64_t restarts_ = 0;
};

}  // namespace g3d::hal::kobuki
