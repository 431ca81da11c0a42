// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/outputs.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d::hal::kobuki;

TEST_CASE("all rails are on at first") { CHECK(Outputs{}.word() == 0x00F0); }

TEST_CASE("changing one output keeps all others") {
  Outputs outputs;
  outputs.set_led(Led::first, LedColour::green);
  CHECK(outputs.word() == 0x02F0);
  outputs.set_led(Led::second, LedColour::orange);
  CHECK(outputs.word() == 0x0EF0);
  outputs.set_led(Led::first, LedColour::red);
  CHECK(outputs.word() == 0x0DF0);
  outputs.set_digital(3, true);
  outputs.set_digital(0, true);
  CHECK(outputs.word() == 0x0DF9);
  outputs.set_rail(Rail::v5, false);
  CHECK(outputs.word() == 0x0DD9);
  outputs.set_led(Led::second, LedColour::off);
  outputs.set_digital(3, false);
  CHECK(outputs.word() == 0x01D1);
}

TEST_CASE("the camera's rail stays on, whatever is switched off") {
  Outputs outputs;
  for (const Rail rail : {Rail::v3_3, Rail::v5, Rail::v12_5A}) outputs.set_rail(rail, false);
  CHECK(outputs.word() == kRail12V1A5);
}

}  // namespace
