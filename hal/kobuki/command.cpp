// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/command.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace g3d::hal::kobuki {
namespace {

// IDs of the protocol; 10 and 11 are reserved and must not be sent.
constexpr std::uint8_t kBaseControl = 1, kSound = 3, kSoundSequence = 4, kRequestExtra = 9, kOutputs = 12,
                       kSetGains = 13, kGetGains = 14;

bool read_block(const Block& block, Command& to) {
  const auto data = block.data;
  switch (block.id) {
    case kBaseControl:
      to.base = BaseControl{get_s16(data, 0), get_s16(data, 2)};
      break;
    case kSound:
      to.sound = Sound{get_u16(data, 0), data[2]};
      break;
    case kSoundSequence:
      if (data[0] >= kSoundSequenceCount) return false;
      to.sound_sequence = static_cast<SoundSequence>(data[0]);
      break;
    case kRequestExtra:
      to.request_extra = get_u16(data, 0);
      break;
    case kOutputs:
      to.outputs = get_u16(data, 0);
      break;
    case kSetGains:
      to.set_gains = ControllerGains{data[0] != 0, get_u32(data, 1), get_u32(data, 5), get_u32(data, 9)};
      break;
    case kGetGains:
      to.get_gains = true;
      break;
    default:
      break;
  }
  return true;
}

}  // namespace

bool command_size_is_right(std::uint8_t id, std::size_t size_bytes) {
  switch (id) {
    case kBaseControl:
      return size_bytes == 4;
    case kSound:
      return size_bytes == 3;
    case kSoundSequence:
    case kGetGains:
      return size_bytes == 1;
    case kRequestExtra:
    case kOutputs:
      return size_bytes == 2;
    case kSetGains:
      return size_bytes == 13;
    default:
      return true;
  }
}

std::size_t encode_command(const Command& command, std::span<std::uint8_t> out) {
  assert(out.size() >= kMaxCommand_bytes && "room for every command");
  if (command == Command{}) return 0;
  FrameWriter frame(out);
  if (command.base) {
    frame.begin_block(kBaseControl, 4);
    frame.put_u16(static_cast<std::uint16_t>(command.base->speed_mmps));
    frame.put_u16(static_cast<std::uint16_t>(command.base->radius_mm));
  }
  if (command.sound) {
    frame.begin_block(kSound, 3);
    frame.put_u16(command.sound->note);
    frame.put_u8(command.sound->duration_ms);
  }
  if (command.sound_sequence) {
    frame.begin_block(kSoundSequence, 1);
    frame.put_u8(static_cast<std::uint8_t>(*command.sound_sequence));
  }
  if (command.request_extra) {
    frame.begin_block(kRequestExtra, 2);
    frame.put_u16(*command.request_extra);
  }
  if (command.outputs) {
    frame.begin_block(kOutputs, 2);
    frame.put_u16(*command.outputs | kRail12V1A5);
  }
  if (command.set_gains) {
    frame.begin_block(kSetGains, 13);
    frame.put_u8(command.set_gains->user_defined ? 1 : 0);
    for (const std::uint32_t gain :
         {command.set_gains->p_milli, command.set_gains->i_milli, command.set_gains->d_milli}) {
      frame.put_u32(gain);
    }
  }
  if (command.get_gains) {
    frame.begin_block(kGetGains, 1);
    frame.put_u8(0);
  }
  return frame.finish();
}

std::size_t encode_base_control(const Twist& twist, std::span<std::uint8_t> out) {
  Command command;
  command.base = to_base_control(twist);
  return encode_command(command, out);
}

Sound sound_of(double frequency_hz, int duration_ms) {
  constexpr double kSecondsPerDigit = 2.75e-6, kLowest_hz = 31.0, kHighest_hz = 20'000.0;
  const double hz = std::isnan(frequency_hz) ? kLowest_hz : std::clamp(frequency_hz, kLowest_hz, kHighest_hz);
  return {static_cast<std::uint16_t>(1.0 / (hz * kSecondsPerDigit)),
          static_cast<std::uint8_t>(std::clamp(duration_ms, 0, 255))};
}

std::optional<Reject> decode_command(std::span<const std::uint8_t> payload, Command& command) {
  Command read;
  std::uint32_t seen = 0;
  Block block;
  while (!payload.empty()) {
    if (!take_block(payload, block)) return Reject::block_overruns;
    if (!command_size_is_right(block.id, block.data.size())) return Reject::wrong_block_size;
    if (block.id < 32) {
      const std::uint32_t bit = std::uint32_t{1} << block.id;
      if ((seen & bit) != 0) return Reject::duplicate_block;
      seen |= bit;
    }
    if (!read_block(block, read)) return Reject::impossible_value;
  }
  command = read;
  return std::nullopt;
}

bool CommandReader::next(Command& command) {
  for (auto payload = scanner_.next(rejects_); !payload.empty(); payload = scanner_.next(rejects_)) {
    const std::optional<Reject> reason = decode_command(payload, command);
    if (!reason) return true;
    rejects_.count(*reason);
  }
  return false;
}

}  // namespace g3d::hal::kobuki
