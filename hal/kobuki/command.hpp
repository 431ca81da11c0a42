// SPDX-License-Identifier: Apache-2.0
// What is said to a Kobuki, one frame at a time, and how a simulated base understands it: like the real one it believes
// only whole frames, found in a stream that may hold anything.
#pragma once

#include <optional>
#include <utility>

#include "hal/kobuki/base_control.hpp"
#include "hal/kobuki/feedback_codec.hpp"

namespace g3d::hal::kobuki {

enum class SoundSequence : std::uint8_t { on, off, recharge, button, error, cleaning_start, cleaning_end };
inline constexpr std::uint8_t kSoundSequenceCount = 7;

inline constexpr std::uint16_t kAskHardware = 0x01, kAskFirmware = 0x02, kAskUdid = 0x08;
inline constexpr std::uint16_t kAskAll = kAskHardware | kAskFirmware | kAskUdid;

/// Bits of the general-purpose output; one word sets them all.
inline constexpr std::uint16_t kDigitalOut = 0x000F, kRail3V3 = 0x0010, kRail5V = 0x0020, kRail12V5A = 0x0040,
                               kRail12V1A5 = 0x0080, kAllRails = 0x00F0, kLed1Red = 0x0100, kLed1Green = 0x0200,
                               kLed2Red = 0x0400, kLed2Green = 0x0800, kLeds = 0x0F00;

struct Sound {
  std::uint16_t note = 0;  ///< 1 / (2.75e-6 * frequency in Hz)
  std::uint8_t duration_ms = 0;
  bool operator==(const Sound&) const = default;
};

/// One frame: each part at most once.
struct Command {
  std::optional<BaseControl> base;
  std::optional<Sound> sound;
  std::optional<SoundSequence> sound_sequence;
  std::optional<std::uint16_t> request_extra;
  std::optional<std::uint16_t> outputs;
  std::optional<ControllerGains> set_gains;
  bool get_gains = false;
  bool operator==(const Command&) const = default;
};

/// All parts take less.
inline constexpr std::size_t kMaxCommand_bytes = 64;

/// The frame into `out`, at least kMaxCommand_bytes; returns its size. The 12 V rail of the Kinect is on in every frame
/// that sets outputs, whatever the word says. A command without parts is no frame: 0.
[[nodiscard]] std::size_t encode_command(const Command& command, std::span<std::uint8_t> out);
[[nodiscard]] std::size_t encode_base_control(const Twist& twist, std::span<std::uint8_t> out);
/// 31 Hz to 20 kHz as a base can sound them; others become the nearest.
[[nodiscard]] Sound sound_of(double frequency_hz, int duration_ms);

/// The SizeRule of command frames.
[[nodiscard]] bool command_size_is_right(std::uint8_t id, std::size_t size_bytes);
/// Fills `command` only if all of `payload` is right; otherwise returns why not. Unknown blocks are skipped.
[[nodiscard]] std::optional<Reject> decode_command(std::span<const std::uint8_t> payload, Command& command);

/// One thread. Allocates nothing.
class CommandReader {
 public:
  /// Calls `on_command(const Command&)` for each frame that `bytes` complete.
  template <typename OnCommand>
  void feed(std::span<const std::uint8_t> bytes, OnCommand&& on_command) {
    while (!bytes.empty()) {
      bytes = bytes.subspan(scanner_.append(bytes));
      Command command;
      while (next(command)) on_command(std::as_const(command));
    }
  }
  [[nodiscard]] const RejectCounts& rejects() const { return rejects_; }

 private:
  [[nodiscard]] bool next(Command& command);

  FrameScanner scanner_{command_size_is_right};
  RejectCounts rejects_;
};

}  // namespace g3d::hal::kobuki
