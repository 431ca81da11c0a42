// SPDX-License-Identifier: Apache-2.0
#include "tests/support/kobuki_packets.hpp"

#include <cmath>

#include "hal/kobuki/feedback_codec.hpp"

namespace g3d::tests {

using hal::kobuki::Feedback;

std::vector<std::uint8_t> from_hex(std::string_view hex) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 2 <= hex.size(); ++i) {
    if (hex[i] == ' ') continue;
    bytes.push_back(static_cast<std::uint8_t>(digit(hex[i]) * 16 + digit(hex[i + 1])));
    ++i;
  }
  return bytes;
}

std::vector<std::uint8_t> frame_of(const Feedback& feedback) {
  std::vector<std::uint8_t> bytes(hal::kobuki::kMaxFrame_bytes);
  bytes.resize(hal::kobuki::encode_feedback(feedback, bytes));
  return bytes;
}

void repair_checksum(std::vector<std::uint8_t>& frame) {
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i + 1 < frame.size(); ++i) sum ^= frame[i];
  frame.back() = sum;
}

Feedback first_packet() {
  Feedback first;
  first.timestamp_ms = 65'400;
  first.left_encoder_ticks = 65'500;
  first.right_encoder_ticks = 20;
  first.charger = 0;
  first.battery_decivolts = 159;
  first.gyro_angle_cdeg = 17'950;
  first.cliff_adc = {1781, 2041, 1680};
  first.current_10mA = {1, 1};
  first.gyro_frame_id = 250;
  first.gyro_sample_count = 2;
  first.gyro[0] = {-95, 8, -56};
  first.gyro[1] = {-112, 3, -49};
  first.digital_in = 0xF;
  first.analog_in = {4060, 4064, 4064, 4064};
  return first;
}

Feedback packet_after(const Feedback& before, int left_ticks, int right_ticks) {
  constexpr double kPi = 3.14159265358979323846;
  Feedback after = before;
  after.timestamp_ms = static_cast<std::uint16_t>(before.timestamp_ms + 20);
  after.left_encoder_ticks = static_cast<std::uint16_t>(before.left_encoder_ticks + left_ticks);
  after.right_encoder_ticks = static_cast<std::uint16_t>(before.right_encoder_ticks + right_ticks);
  const double turn_rad = (right_ticks - left_ticks) * hal::kobuki::kMetresPerTick / hal::kobuki::kWheelBase_m;
  const int turn_cdeg = static_cast<int>(std::lround(turn_rad * 18'000 / kPi));
  int angle_cdeg = before.gyro_angle_cdeg + turn_cdeg;
  if (angle_cdeg > 18'000) angle_cdeg -= 36'000;
  if (angle_cdeg <= -18'000) angle_cdeg += 36'000;
  after.gyro_angle_cdeg = static_cast<std::int16_t>(angle_cdeg);
  after.gyro_rate_cdegps = static_cast<std::int16_t>(turn_cdeg * 50);
  after.left_pwm = static_cast<std::int8_t>(left_ticks / 3);
  after.right_pwm = static_cast<std::int8_t>(right_ticks / 3);
  after.gyro_frame_id = static_cast<std::uint8_t>(before.gyro_frame_id + 2);
  const int wobble = before.timestamp_ms % 7;
  for (std::uint16_t& reading : after.cliff_adc) reading = static_cast<std::uint16_t>(reading - wobble + 3);
  for (auto& sample : after.gyro) sample.z = static_cast<std::int16_t>(sample.z + wobble - 3);
  return after;
}

}  // namespace g3d::tests
