// SPDX-License-Identifier: Apache-2.0
// A Kinect's foot by its protocol, without a Kinect: a motor that takes its time, an accelerometer in a head that the
// motor turns, a light; and what can go wrong with it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "hal/clock.hpp"
#include "hal/kinect/usb_control.hpp"

namespace g3d::test {

struct ScriptedFootState {
  double head_deg = 15.0;  ///< where it stands, against the horizon
  double target_deg = 15.0;
  double roll_deg = 0.0;        ///< of the robot
  double step_deg = 2.0;        ///< that the motor turns between two questions
  double stop_deg = 31.0;       ///< where it cannot turn further
  double axis_error_deg = 0.0;  ///< by which the accelerometer is mounted wrongly
  double z_sign = 1.0;
  double noise_g = 0.0;
  int light = -1;
  bool is_gone = false;
  bool is_free_fall = false;
  std::size_t answer_bytes = 10;
  std::vector<std::uint8_t> requests;
};

class ScriptedFoot final : public hal::kinect::UsbControl {
 public:
  explicit ScriptedFoot(ScriptedFootState& state) : state_(state) {}

  bool write(std::uint8_t request, std::uint16_t value) override {
    state_.requests.push_back(request);
    if (state_.is_gone) return false;
    if (request == 0x31) state_.target_deg = static_cast<std::int16_t>(value) / 2.0;
    if (request == 0x06) state_.light = value;
    return true;
  }

  int read(std::uint8_t request, std::span<std::uint8_t> into) override {
    state_.requests.push_back(request);
    if (state_.is_gone || request != 0x32 || into.size() < 10) return -1;
    const double before_deg = state_.head_deg;
    const double way_deg = std::clamp(state_.target_deg, -state_.stop_deg, state_.stop_deg) - state_.head_deg;
    state_.head_deg += std::clamp(way_deg, -state_.step_deg, state_.step_deg);
    const bool is_moving = std::abs(state_.head_deg - before_deg) > 1e-9;
    const bool is_at_stop = !is_moving && std::abs(state_.target_deg) > state_.stop_deg;
    constexpr double kRadians = std::numbers::pi / 180.0;
    const double pitch_rad = kRadians * (state_.head_deg + state_.axis_error_deg),
                 roll_rad = kRadians * state_.roll_deg;
    state_.noise_g = -state_.noise_g;
    const double scale = state_.is_free_fall ? 0.05 : 1.0;
    put(into, 2, scale * std::cos(pitch_rad) * std::sin(roll_rad));
    put(into, 4, scale * std::cos(pitch_rad) * std::cos(roll_rad) + state_.noise_g);
    put(into, 6, scale * state_.z_sign * std::sin(pitch_rad));
    into[8] =
        is_moving ? 0x80 : static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(2.0 * state_.head_deg)));
    into[9] = is_moving ? 4 : is_at_stop ? 1 : 0;
    return static_cast<int>(state_.answer_bytes);
  }

 private:
  static void put(std::span<std::uint8_t> into, std::size_t at, double g) {
    const auto counts = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(819.0 * g)));
    into[at] = static_cast<std::uint8_t>(counts >> 8);
    into[at + 1] = static_cast<std::uint8_t>(counts);
  }
  ScriptedFootState& state_;
};

/// Time that passes as somebody sleeps.
class LeapingClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::TimeNs now() const override { return now_ns_; }
  void sleep_until(hal::TimeNs t_ns) override { now_ns_ = std::max(now_ns_, t_ns); }

 private:
  hal::TimeNs now_ns_ = 1'000'000'000;
};

}  // namespace g3d::test
