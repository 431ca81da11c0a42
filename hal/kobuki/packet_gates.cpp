// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/packet_gates.hpp"

#include <cstdlib>

namespace g3d::hal::kobuki {
namespace {

constexpr int kHalfTurn_cdeg = 18'000;
constexpr int kMaxAdc = 4095;
constexpr int kGyroPeriod_ms = 10;

/// Samples come at about 100 Hz of the gyro's own clock: 2 per packet, now and then 3.
bool gyro_count_fits(const Feedback& from, const Feedback& to, int elapsed_ms) {
  if (from.gyro_sample_count == 0 || to.gyro_sample_count == 0) return true;
  const int samples = static_cast<std::uint8_t>(to.gyro_frame_id - from.gyro_frame_id);
  return std::abs(samples - elapsed_ms / kGyroPeriod_ms) <= 2 + elapsed_ms / 50;
}

}  // namespace

int angle_between_cdeg(std::int16_t from, std::int16_t to) {
  int angle_cdeg = (to - from) % (2 * kHalfTurn_cdeg);
  if (angle_cdeg > kHalfTurn_cdeg) angle_cdeg -= 2 * kHalfTurn_cdeg;
  if (angle_cdeg <= -kHalfTurn_cdeg) angle_cdeg += 2 * kHalfTurn_cdeg;
  return angle_cdeg;
}

int max_ticks_in(int elapsed_ms) {
  return 1 + static_cast<int>(kMaxWheelSpeed_mps * elapsed_ms / (1000.0 * kMetresPerTick));
}

int max_angle_in_cdeg(int elapsed_ms) { return 50 + kMaxTurn_cdegps * elapsed_ms / 1000; }

std::optional<Reject> impossible_value(const Feedback& feedback) {
  // One by one, no flag has more bits than these; nor has any a reading beyond 12 bits.
  const bool has_reserved_bits = (feedback.bumper & ~7) != 0 || (feedback.wheel_drop & ~3) != 0 ||
                                 (feedback.cliff & ~7) != 0 || (feedback.over_current & ~3) != 0 ||
                                 (feedback.buttons & ~7) != 0;
  if (has_reserved_bits) return Reject::impossible_value;
  for (const std::uint8_t seen : feedback.dock_ir) {
    if ((seen & ~0x3F) != 0) return Reject::impossible_value;
  }
  for (const std::uint16_t reading : feedback.cliff_adc) {
    if (reading > kMaxAdc) return Reject::impossible_value;
  }
  for (const std::uint16_t reading : feedback.analog_in) {
    if (reading > kMaxAdc) return Reject::impossible_value;
  }
  if (std::abs(int{feedback.gyro_angle_cdeg}) > kHalfTurn_cdeg) return Reject::impossible_value;
  if (std::abs(int{feedback.gyro_rate_cdegps}) > kMaxTurn_cdegps) return Reject::impossible_value;
  if (feedback.battery_decivolts < kMinBattery_decivolts || feedback.battery_decivolts > kMaxBattery_decivolts) {
    return Reject::battery_voltage;
  }
  return std::nullopt;
}

std::optional<Reject> impossible_step(const Feedback& from, const Feedback& to) {
  const int elapsed_ms = ms_between(from, to);
  if (elapsed_ms < 1 || elapsed_ms > kMaxTimeStep_ms) return Reject::time_step;
  const int max_ticks = max_ticks_in(elapsed_ms);
  if (std::abs(ticks_between(from.left_encoder_ticks, to.left_encoder_ticks)) > max_ticks ||
      std::abs(ticks_between(from.right_encoder_ticks, to.right_encoder_ticks)) > max_ticks) {
    return Reject::encoder_step;
  }
  if (std::abs(angle_between_cdeg(from.gyro_angle_cdeg, to.gyro_angle_cdeg)) > max_angle_in_cdeg(elapsed_ms)) {
    return Reject::gyro_angle_step;
  }
  if (!gyro_count_fits(from, to, elapsed_ms)) return Reject::gyro_frame_step;
  return std::nullopt;
}

}  // namespace g3d::hal::kobuki
