// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_kobuki.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace g3d::hal {
namespace {

using kobuki::Feedback;

constexpr double kCdegPerRad = 18000.0 / std::numbers::pi;
constexpr double kGyroDigitsPerRadps = 180.0 / std::numbers::pi / 0.00875;
constexpr double kPacketPeriod_s = 0.02;
constexpr int kGyroSamples = 2;  // in a packet
static_assert(kGyroSamples == kGyroRate_hz * kPacketPeriod_s);
constexpr double kDangerousBattery_V = 13.2;
constexpr TimeNs kOverCurrentAfter_ns = 100'000'000;
constexpr std::uint16_t kFloorAdc = 1850;  // captures: 1600 to 2050
constexpr std::uint16_t kCliffAdc = 320;

std::int64_t rounded(double x) { return static_cast<std::int64_t>(std::floor(x + 0.5)); }

template <typename T>
T saturated(double x, double low, double high) {
  return static_cast<T>(rounded(std::clamp(x, low, high)));
}

/// In (-18000, 18000].
std::int16_t wrapped_cdeg(double angle_rad) {
  std::int64_t cdeg = rounded(angle_rad * kCdegPerRad) % 36000;
  if (cdeg > 18000) cdeg -= 36000;
  if (cdeg <= -18000) cdeg += 36000;
  return static_cast<std::int16_t>(cdeg);
}

}  // namespace

SimKobuki::SimKobuki(const SimKobukiOptions& options)
    : options_(options),
      to_host_(options.seed * 4 + 1),
      to_base_(options.seed * 4 + 2),
      random_(options.seed * 4 + 3),
      gyro_angle_rad_(options.first_angle_deg * std::numbers::pi / 180.0),
      gyro_bias_radps_(options.gyro_bias_radps) {
  set_noise(options.to_host, options.to_base);
}

void SimKobuki::set_noise(const LineNoise& to_host, const LineNoise& to_base) {
  to_host_.set_noise(to_host);
  to_base_.set_noise(to_base);
}

std::size_t SimKobuki::read(std::span<std::uint8_t> into) {
  return faults_.unplugged ? 0 : to_host_.pop(into, now_ns_);
}

bool SimKobuki::write(std::span<const std::uint8_t> bytes) {
  if (faults_.unplugged) return false;
  if (faults_.deaf) return true;
  return to_base_.push(bytes, now_ns_);
}

void SimKobuki::sense(const RobotBody& body) {
  sensed_ = {body.wheel_way_m(), body.wheel_speeds_mps(),    wheels_for_command(drive_.speed_mmps, drive_.radius_mm),
             body.turned_rad(),  body.velocity().turn_radps, body.sense().bumper,
             body.sense().cliff, body.sense().wheel_drop,    body.sense().stalled};
}

void SimKobuki::advance_to(TimeNs now_ns) {
  now_ns_ = std::max(now_ns_, now_ns);
  if (faults_.unplugged) {
    to_host_.clear();
    to_base_.clear();
  }
  take_commands();
  if (!sensed_.stalled) {
    stalled_since_ns_ = -1;
  } else if (stalled_since_ns_ < 0) {
    stalled_since_ns_ = now_ns_;
  }
  while (next_packet_ns_ <= now_ns_) {
    send_packet(next_packet_ns_);
    ++packet_number_;
    const double period_ns = static_cast<double>(kobuki::kPacketPeriod_ns) / (1.0 + options_.clock_ppm * 1e-6);
    next_packet_ns_ = rounded(static_cast<double>(packet_number_) * period_ns);
  }
}

void SimKobuki::take_commands() {
  std::array<std::uint8_t, 256> bytes;
  for (;;) {
    const std::span<const std::uint8_t> arrived(bytes.data(), to_base_.pop(bytes, now_ns_));
    if (arrived.empty()) return;
    reader_.feed(arrived, [this](const kobuki::Command& command) { obey(command); });
  }
}

void SimKobuki::obey(const kobuki::Command& command) {
  if (command.base) {
    drive_ = *command.base;
    ++drive_commands_;
  }
  if (command.outputs) outputs_ = *command.outputs;
  if (command.sound) ++sounds_;
  if (command.sound_sequence) ++sounds_;
  if (command.set_gains) gains_ = *command.set_gains;
  if (command.get_gains) packet_.gains = gains_;
  const std::uint16_t asked = command.request_extra.value_or(0);
  kobuki::DeviceInfo& info = packet_.info;
  if ((asked & kobuki::kAskHardware) != 0) {
    info.has_hardware = true;
    info.hardware = options_.hardware;
  }
  if ((asked & kobuki::kAskFirmware) != 0) {
    info.has_firmware = true;
    info.firmware = options_.firmware;
  }
  if ((asked & kobuki::kAskUdid) != 0) {
    info.has_udid = true;
    info.udid = options_.udid;
  }
}

void SimKobuki::send_packet(TimeNs at_ns) {
  const auto to_ticks = [](double way_m) { return way_m / kobuki::kMetresPerTick; };
  if (!faults_.left_dead) left_ticks_ += to_ticks(sensed_.way_m.left - reported_.way_m.left) * options_.left_scale;
  if (!faults_.right_dead) right_ticks_ += to_ticks(sensed_.way_m.right - reported_.way_m.right) * options_.right_scale;

  Feedback& f = packet_.feedback;
  f = {};
  const std::int64_t base_ms = static_cast<std::int64_t>(packet_number_) * (kobuki::kPacketPeriod_ns / 1'000'000);
  f.timestamp_ms = static_cast<std::uint16_t>(options_.first_timestamp_ms + base_ms);
  f.bumper = sensed_.bumper;
  f.cliff = sensed_.cliff;
  f.wheel_drop = sensed_.wheel_drop;
  f.left_encoder_ticks = static_cast<std::uint16_t>(options_.first_left_ticks + rounded(left_ticks_));
  f.right_encoder_ticks = static_cast<std::uint16_t>(options_.first_right_ticks + rounded(right_ticks_));
  f.buttons = faults_.buttons;
  f.charger = faults_.charger;
  f.cliff_adc = {(f.cliff & kobuki::kCliffRight) != 0 ? kCliffAdc : kFloorAdc,
                 (f.cliff & kobuki::kCliffCentre) != 0 ? kCliffAdc : kFloorAdc,
                 (f.cliff & kobuki::kCliffLeft) != 0 ? kCliffAdc : kFloorAdc};
  f.digital_in = 0x000F;
  f.analog_in = {4060, 4064, 4064, 4064};
  fill_gyro(f);
  fill_motors(f, at_ns);
  reported_ = sensed_;
  if (faults_.silent || faults_.unplugged) return;
  if (faults_.keep_every > 1 && packet_number_ % static_cast<std::uint64_t>(faults_.keep_every) != 0) return;
  if (faults_.scrambled) {
    f.left_encoder_ticks = static_cast<std::uint16_t>(random_.bits());
    f.right_encoder_ticks = static_cast<std::uint16_t>(random_.bits());
    f.gyro_angle_cdeg = static_cast<std::int16_t>(static_cast<int>(random_.bits() % 36000) - 17999);
  }
  if (!faults_.stuck || frame_bytes_ == 0) {
    frame_bytes_ = kobuki::encode_feedback(packet_, frame_);
    packet_.info = {};
    packet_.gains.reset();
  }
  ++packets_sent_;
  if (!to_host_.push(std::span(frame_).first(frame_bytes_), at_ns)) ++packets_dropped_;
}

void SimKobuki::fill_gyro(Feedback& f) {
  if (options_.gyro_drift_radps_per_sqrt_s > 0.0) {
    gyro_bias_radps_ += options_.gyro_drift_radps_per_sqrt_s * std::sqrt(kPacketPeriod_s) * random_.gaussian();
  }
  double noise_radps = 0.0;
  f.gyro_frame_id = gyro_frame_;
  f.gyro_sample_count = kGyroSamples;
  gyro_frame_ = static_cast<std::uint8_t>(gyro_frame_ + kGyroSamples);
  for (int i = 0; i < kGyroSamples; ++i) {
    const double noise = options_.gyro_noise_radps > 0.0 ? options_.gyro_noise_radps * random_.gaussian() : 0.0;
    noise_radps += noise / kGyroSamples;
    const double radps = sensed_.turn_radps * options_.gyro_scale + gyro_bias_radps_ + noise;
    f.gyro[static_cast<std::size_t>(i)].z = saturated<std::int16_t>(radps * kGyroDigitsPerRadps, -32768.0, 32767.0);
  }
  gyro_angle_rad_ += (sensed_.turned_rad - reported_.turned_rad) * options_.gyro_scale +
                     (gyro_bias_radps_ + noise_radps) * kPacketPeriod_s;
  f.gyro_angle_cdeg = wrapped_cdeg(gyro_angle_rad_);
  const double rate_radps = sensed_.turn_radps * options_.gyro_scale + gyro_bias_radps_ + noise_radps;
  f.gyro_rate_cdegps = saturated<std::int16_t>(rate_radps * kCdegPerRad, -32768.0, 32767.0);
}

void SimKobuki::fill_motors(Feedback& f, TimeNs at_ns) {
  const double drained = std::min(static_cast<double>(at_ns) / 1e9 / options_.battery_life_s, 1.0);
  const double volts = options_.battery_V - (options_.battery_V - kDangerousBattery_V) * drained;
  f.battery_decivolts = saturated<std::uint8_t>(volts * 10.0, 0.0, 255.0);
  const auto pwm = [](double target_mps) { return saturated<std::int8_t>(target_mps * 180.0, -127.0, 127.0); };
  f.left_pwm = pwm(sensed_.target_mps.left);
  f.right_pwm = pwm(sensed_.target_mps.right);
  const auto current = [&](double target_mps, double speed_mps) {
    if (sensed_.stalled && target_mps != 0.0) return std::uint8_t{255};
    return saturated<std::uint8_t>(1.0 + 40.0 * std::abs(speed_mps), 0.0, 255.0);
  };
  f.current_10mA = {current(sensed_.target_mps.left, sensed_.speeds_mps.left),
                    current(sensed_.target_mps.right, sensed_.speeds_mps.right)};
  if (stalled_since_ns_ >= 0 && at_ns - stalled_since_ns_ >= kOverCurrentAfter_ns) {
    if (sensed_.target_mps.left != 0.0) f.over_current |= kobuki::kOverCurrentLeft;
    if (sensed_.target_mps.right != 0.0) f.over_current |= kobuki::kOverCurrentRight;
  }
}

}  // namespace g3d::hal
