// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/signals.hpp"

#include <array>

namespace g3d::hal::kobuki {
namespace {

constexpr TimeNs kBetweenSounds_ns = 1'000'000'000;

// What begins to hold is told by this sound; the first row that fits counts.
struct SoundRow {
  Condition began;
  SoundSequence sound;
};
constexpr std::array<SoundRow, 9> kSounds{{
    {Condition::e_stop, SoundSequence::error},
    {Condition::wheel_drop, SoundSequence::error},
    {Condition::wrong_firmware, SoundSequence::error},
    {Condition::battery_empty, SoundSequence::error},
    {Condition::dead_wheel, SoundSequence::error},
    {Condition::over_current, SoundSequence::error},
    {Condition::cliff, SoundSequence::error},
    {Condition::silent_camera, SoundSequence::error},
    {Condition::battery_low, SoundSequence::recharge},
}};

LedColour colour_of(SafetyState state) {
  switch (state) {
    case SafetyState::free:
      return LedColour::green;
    case SafetyState::careful:
    case SafetyState::back_or_turn:
    case SafetyState::back_off:
    case SafetyState::turn_only:
      return LedColour::orange;
    default:
      return LedColour::red;
  }
}

}  // namespace

Signal Signals::update(const Verdict& verdict, Conditions conditions, TimeNs now_ns) {
  Signal signal;
  signal.state = colour_of(verdict.state);
  signal.battery = conditions.has(Condition::battery_empty) ? LedColour::red
                   : conditions.has(Condition::battery_low) ? LedColour::orange
                                                            : LedColour::green;
  std::optional<SoundSequence> sound;
  if (was_ready_) {  // before, everything is wrong once
    for (const SoundRow& row : kSounds) {
      if (!sound && conditions.has(row.began) && !last_.has(row.began)) sound = row.sound;
    }
    if (!sound && last_.has(Condition::e_stop) && !conditions.has(Condition::e_stop)) sound = SoundSequence::button;
  } else if (verdict.state == SafetyState::free || verdict.state == SafetyState::careful) {
    was_ready_ = true;
    sound = SoundSequence::on;
  }
  if (sound && has_sounded_ && now_ns - sounded_ns_ < kBetweenSounds_ns) return signal;  // told when there is room
  if (sound) {
    has_sounded_ = true;
    sounded_ns_ = now_ns;
    signal.sound = sound;
  }
  last_ = conditions;
  return signal;
}

}  // namespace g3d::hal::kobuki
