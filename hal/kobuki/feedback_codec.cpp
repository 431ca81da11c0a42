// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/feedback_codec.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::hal::kobuki {
namespace {

using Bytes = std::span<const std::uint8_t>;

// IDs of the protocol; 2, 7, 8, 9, 12, 14, 15, 17, 18 and 20 are reserved.
constexpr std::uint8_t kCore = 1, kDockIr = 3, kInertial = 4, kCliff = 5, kCurrent = 6, kHardware = 10, kFirmware = 11,
                       kRawGyro = 13, kGpInput = 16, kUdid = 19, kGains = 21;
constexpr std::uint32_t bit(std::uint8_t id) { return std::uint32_t{1} << id; }
/// Every firmware since 1.0 sends these in every packet.
constexpr std::uint32_t kRequired =
    bit(kCore) | bit(kDockIr) | bit(kInertial) | bit(kCliff) | bit(kCurrent) | bit(kGpInput);

void read_core(Bytes data, Feedback& to) {
  to.timestamp_ms = get_u16(data, 0);
  to.bumper = data[2];
  to.wheel_drop = data[3];
  to.cliff = data[4];
  to.left_encoder_ticks = get_u16(data, 5);
  to.right_encoder_ticks = get_u16(data, 7);
  to.left_pwm = static_cast<std::int8_t>(data[9]);
  to.right_pwm = static_cast<std::int8_t>(data[10]);
  to.buttons = data[11];
  to.charger = data[12];
  to.battery_decivolts = data[13];
  to.over_current = data[14];
}

void write_core(const Feedback& from, FrameWriter& out) {
  out.begin_block(kCore, 15);
  out.put_u16(from.timestamp_ms);
  out.put_u8(from.bumper);
  out.put_u8(from.wheel_drop);
  out.put_u8(from.cliff);
  out.put_u16(from.left_encoder_ticks);
  out.put_u16(from.right_encoder_ticks);
  out.put_u8(static_cast<std::uint8_t>(from.left_pwm));
  out.put_u8(static_cast<std::uint8_t>(from.right_pwm));
  out.put_u8(from.buttons);
  out.put_u8(from.charger);
  out.put_u8(from.battery_decivolts);
  out.put_u8(from.over_current);
}

/// count is that of numbers, not of samples: three per sample. A size of its own would overrun `gyro`.
bool read_raw_gyro(Bytes data, Feedback& to) {
  const std::size_t numbers = data[1];
  if (data.size() != 2 + 2 * numbers || numbers % 3 != 0 || numbers > 3 * to.gyro.size()) return false;
  to.gyro_frame_id = data[0];
  to.gyro_sample_count = static_cast<std::uint8_t>(numbers / 3);
  for (std::size_t i = 0; i < to.gyro_sample_count; ++i) {
    to.gyro[i] = {get_s16(data, 2 + 6 * i), get_s16(data, 4 + 6 * i), get_s16(data, 6 + 6 * i)};
  }
  return true;
}

void write_raw_gyro(const Feedback& from, FrameWriter& out) {
  const std::size_t samples = std::min<std::size_t>(from.gyro_sample_count, from.gyro.size());
  if (samples == 0) return;
  out.begin_block(kRawGyro, static_cast<std::uint8_t>(2 + 6 * samples));
  out.put_u8(from.gyro_frame_id);
  out.put_u8(static_cast<std::uint8_t>(3 * samples));
  for (std::size_t i = 0; i < samples; ++i) {
    for (const std::int16_t value : {from.gyro[i].x, from.gyro[i].y, from.gyro[i].z}) {
      out.put_u16(static_cast<std::uint16_t>(value));
    }
  }
}

using Version = std::array<std::uint8_t, 3>;

Version from_digits(std::uint32_t number, std::uint32_t base) {
  return {static_cast<std::uint8_t>(number / (base * base)), static_cast<std::uint8_t>(number / base % base),
          static_cast<std::uint8_t>(number % base)};
}

/// Patch, minor, major, 0; very old firmware sends two bytes instead: 104 is 1.0.4, 10101 is 1.1.1.
Version read_version(Bytes data, bool is_firmware) {
  if (data.size() == 4) return {data[2], data[1], data[0]};
  const std::uint32_t number = get_u16(data, 0);
  constexpr std::uint32_t kFirst = 123;  // what firmware 1.0.0 calls itself
  if (is_firmware && number == kFirst) return {1, 0, 0};
  return number >= 10'000 ? from_digits(number, 100) : from_digits(number % 1000, 10);
}

void write_version(std::uint8_t id, const Version& version, FrameWriter& out) {
  out.begin_block(id, 4);
  for (const std::uint8_t byte : {version[2], version[1], version[0], std::uint8_t{0}}) out.put_u8(byte);
}

bool read_block(const Block& block, Packet& to) {
  const Bytes data = block.data;
  Feedback& feedback = to.feedback;
  switch (block.id) {
    case kCore:
      read_core(data, feedback);
      break;
    case kDockIr:
      std::copy_n(data.begin(), 3, feedback.dock_ir.begin());
      break;
    case kInertial:
      feedback.gyro_angle_cdeg = get_s16(data, 0);
      feedback.gyro_rate_cdegps = get_s16(data, 2);
      break;
    case kCliff:
      for (std::size_t i = 0; i < 3; ++i) feedback.cliff_adc[i] = get_u16(data, 2 * i);
      break;
    case kCurrent:
      feedback.current_10mA = {data[0], data[1]};
      break;
    case kRawGyro:
      return read_raw_gyro(data, feedback);
    case kGpInput:
      feedback.digital_in = get_u16(data, 0);
      for (std::size_t i = 0; i < 4; ++i) feedback.analog_in[i] = get_u16(data, 2 + 2 * i);
      break;
    case kHardware:
      to.info.has_hardware = true;
      to.info.hardware = read_version(data, false);
      break;
    case kFirmware:
      to.info.has_firmware = true;
      to.info.firmware = read_version(data, true);
      break;
    case kUdid:
      to.info.has_udid = true;
      for (std::size_t i = 0; i < 3; ++i) to.info.udid[i] = get_u32(data, 4 * i);
      break;
    case kGains:
      to.gains = ControllerGains{data[0] != 0, get_u32(data, 1), get_u32(data, 5), get_u32(data, 9)};
      break;
    default:
      break;  // reserved, or newer than this program
  }
  return true;
}

}  // namespace

bool feedback_size_is_right(std::uint8_t id, std::size_t size_bytes) {
  switch (id) {
    case kCore:
      return size_bytes == 15;
    case kDockIr:
      return size_bytes == 3;
    case kInertial:
      return size_bytes == 7;
    case kCliff:
      return size_bytes == 6;
    case kCurrent:
      return size_bytes == 2;
    case kHardware:
    case kFirmware:
      return size_bytes == 4 || size_bytes == 2;
    case kRawGyro:
      return size_bytes >= 2 && size_bytes <= 50 && (size_bytes - 2) % 6 == 0;
    case kGpInput:
      return size_bytes == 16;
    case kUdid:
      return size_bytes == 12;
    case kGains:
      return size_bytes == 13;
    default:
      return true;
  }
}

std::optional<Reject> decode_feedback(Bytes payload, Packet& packet) {
  Packet read;
  std::uint32_t seen = 0;
  Block block;
  while (!payload.empty()) {
    if (!take_block(payload, block)) return Reject::block_overruns;
    if (!feedback_size_is_right(block.id, block.data.size())) return Reject::wrong_block_size;
    if (block.id < 32) {
      if ((seen & bit(block.id)) != 0) return Reject::duplicate_block;
      seen |= bit(block.id);
    }
    if (!read_block(block, read)) return Reject::wrong_block_size;
  }
  if ((seen & kRequired) != kRequired) return Reject::missing_block;
  packet = read;
  return std::nullopt;
}

std::size_t encode_feedback(const Packet& packet, std::span<std::uint8_t> out) {
  assert(out.size() >= kMaxFrame_bytes && "room for every packet");
  const Feedback& from = packet.feedback;
  FrameWriter frame(out);
  write_core(from, frame);
  frame.begin_block(kDockIr, 3);
  for (const std::uint8_t byte : from.dock_ir) frame.put_u8(byte);
  frame.begin_block(kInertial, 7);
  frame.put_u16(static_cast<std::uint16_t>(from.gyro_angle_cdeg));
  frame.put_u16(static_cast<std::uint16_t>(from.gyro_rate_cdegps));
  for (int i = 0; i < 3; ++i) frame.put_u8(0);
  frame.begin_block(kCliff, 6);
  for (const std::uint16_t reading : from.cliff_adc) frame.put_u16(reading);
  frame.begin_block(kCurrent, 2);
  for (const std::uint8_t reading : from.current_10mA) frame.put_u8(reading);
  write_raw_gyro(from, frame);
  frame.begin_block(kGpInput, 16);
  frame.put_u16(from.digital_in);
  for (const std::uint16_t reading : from.analog_in) frame.put_u16(reading);
  for (int i = 0; i < 3; ++i) frame.put_u16(0);
  if (packet.info.has_hardware) write_version(kHardware, packet.info.hardware, frame);
  if (packet.info.has_firmware) write_version(kFirmware, packet.info.firmware, frame);
  if (packet.info.has_udid) {
    frame.begin_block(kUdid, 12);
    for (const std::uint32_t part : packet.info.udid) frame.put_u32(part);
  }
  if (packet.gains) {
    frame.begin_block(kGains, 13);
    frame.put_u8(packet.gains->user_defined ? 1 : 0);
    for (const std::uint32_t gain : {packet.gains->p_milli, packet.gains->i_milli, packet.gains->d_milli}) {
      frame.put_u32(gain);
    }
  }
  return frame.finish();
}

std::size_t encode_feedback(const Feedback& feedback, std::span<std::uint8_t> out) {
  return encode_feedback(Packet{feedback, {}, {}}, out);
}

}  // namespace g3d::hal::kobuki
