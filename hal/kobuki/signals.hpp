// SPDX-License-Identifier: Apache-2.0
// What the base shows and sounds, so that who stands next to it knows how it is. First LED: green drives freely, orange
// only carefully or not forward, red stands. Second LED: the battery.
#pragma once

#include <optional>

#include "hal/kobuki/outputs.hpp"
#include "hal/messages.hpp"
#include "hal/safety.hpp"

namespace g3d::hal::kobuki {

struct Signal {
  LedColour state = LedColour::off;
  LedColour battery = LedColour::off;
  std::optional<SoundSequence> sound;
};

/// One thread. Remembers what was said last, so that a sound is heard once.
class Signals {
 public:
  [[nodiscard]] Signal update(const Verdict& verdict, Conditions conditions, TimeNs now_ns);

 private:
  Conditions last_;
  bool was_ready_ = false;
  bool has_sounded_ = false;
  TimeNs sounded_ns_ = 0;
};

}  // namespace g3d::hal::kobuki
