// SPDX-License-Identifier: Apache-2.0
// The base's outputs as they are meant to be: one command sets rails, LEDs and digital outputs all at once, so that
// whoever changes one must know the others. All rails begin on; the 12 V rail that feeds the Kinect cannot be dropped.
#pragma once

#include <cstdint>

#include "hal/kobuki/command.hpp"

namespace g3d::hal::kobuki {

enum class Led : std::uint8_t { first, second };
enum class LedColour : std::uint8_t { off, red, green, orange };
enum class Rail : std::uint8_t { v3_3, v5, v12_5A };

/// One thread.
class Outputs {
 public:
  void set_led(Led led, LedColour colour);
  void set_rail(Rail rail, bool on);
  /// Precondition: index < 4.
  void set_digital(int index, bool on);
  /// What Command::outputs must be.
  [[nodiscard]] std::uint16_t word() const { return word_; }

 private:
  void set(std::uint16_t bits, bool on);
  std::uint16_t word_ = kAllRails;
};

}  // namespace g3d::hal::kobuki
