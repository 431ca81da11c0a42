// SPDX-License-Identifier: Apache-2.0
// The payload of a feedback packet as values, and back (kobuki_documentation, protocol; where it errs, captured packets
// decide). The whole payload is checked before anything of it is handed out. The simulated base speaks by the encoder.
#pragma once

#include <optional>

#include "hal/kobuki/feedback.hpp"
#include "hal/kobuki/frame_scanner.hpp"

namespace g3d::hal::kobuki {

/// Of the wheels' speed controller, times 1000.
struct ControllerGains {
  bool user_defined = false;
  std::uint32_t p_milli = 100'000;
  std::uint32_t i_milli = 100;
  std::uint32_t d_milli = 2'000;
  bool operator==(const ControllerGains&) const = default;
};

/// What one packet holds; `received_ns` is left 0.
struct Packet {
  Feedback feedback;
  DeviceInfo info;  ///< only the answers that this packet brings
  std::optional<ControllerGains> gains;
};

/// The SizeRule of feedback frames.
[[nodiscard]] bool feedback_size_is_right(std::uint8_t id, std::size_t size_bytes);

/// Fills `packet` only if all of `payload` is right; otherwise returns why not.
[[nodiscard]] std::optional<Reject> decode_feedback(std::span<const std::uint8_t> payload, Packet& packet);

/// The whole frame into `out`, which has at least kMaxFrame_bytes; returns its size. Answers are sent if present.
[[nodiscard]] std::size_t encode_feedback(const Packet& packet, std::span<std::uint8_t> out);
[[nodiscard]] std::size_t encode_feedback(const Feedback& feedback, std::span<std::uint8_t> out);

}  // namespace g3d::hal::kobuki
