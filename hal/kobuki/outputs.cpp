// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/outputs.hpp"

#include <cassert>

namespace g3d::hal::kobuki {

void Outputs::set(std::uint16_t bits, bool on) {
  word_ = static_cast<std::uint16_t>(on ? word_ | bits : word_ & ~bits);
}

void Outputs::set_led(Led led, LedColour colour) {
  const bool is_first = led == Led::first;
  set(is_first ? kLed1Red : kLed2Red, colour == LedColour::red || colour == LedColour::orange);
  set(is_first ? kLed1Green : kLed2Green, colour == LedColour::green || colour == LedColour::orange);
}

void Outputs::set_rail(Rail rail, bool on) {
  switch (rail) {
    case Rail::v3_3:
      set(kRail3V3, on);
      break;
    case Rail::v5:
      set(kRail5V, on);
      break;
    case Rail::v12_5A:
      set(kRail12V5A, on);
      break;
  }
}

void Outputs::set_digital(int index, bool on) {
  assert(index >= 0 && index < 4 && "four digital outputs");
  set(static_cast<std::uint16_t>(1U << static_cast<unsigned>(index)), on);
}

}  // namespace g3d::hal::kobuki
