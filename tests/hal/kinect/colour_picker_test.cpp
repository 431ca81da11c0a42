// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>
#include <vector>

#include "hal/kinect/colour_picker.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

namespace {

void send_colour(ImageIntake& intake, std::uint8_t value, std::uint64_t ticks) {
  const std::vector<std::uint8_t> rgb(3 * 16 * 16, value);
  SensorImage image;
  image.kind = ImageKind::colour;
  image.width_px = image.height_px = 16;
  image.stride_bytes = 48;
  image.bytes = rgb;
  image.device_ticks = ticks;
  intake.take(image);
}

}  // namespace

TEST_CASE("each depth image gets the colour image nearest to it, also when newer ones have come") {
  ImageIntake intake(16, 16);
  ColourPicker picker(intake);
  picker.begin(1000.0, 64);
  CHECK(picker.pick(1'000'000, 34'000'000) == nullptr);
  for (std::uint8_t i = 0; i < 4; ++i) send_colour(intake, i, 1'000'000 + 33'333ULL * i);
  for (std::uint8_t i = 0; i < 4; ++i) {
    const std::uint8_t* const rgb = picker.pick(1'005'000 + 33'333ULL * i, 34'000'000);
    REQUIRE(rgb != nullptr);
    CHECK(*rgb == i);
  }
  // The last one again, as long as it is near.
  CHECK(picker.pick(1'125'000, 34'000'000) != nullptr);
  CHECK(picker.pick(1'200'000, 34'000'000) == nullptr);
  // Long afterwards nothing is stuck.
  for (std::uint8_t i = 0; i < 50; ++i) {
    send_colour(intake, i, 2'000'000 + 33'333ULL * i);
    const std::uint8_t* const rgb = picker.pick(2'000'000 + 33'333ULL * i, 34'000'000);
    REQUIRE(rgb != nullptr);
    CHECK(*rgb == i);
  }
  CHECK(intake.overruns(ImageKind::colour) == 0);
}

TEST_CASE("a sensor's clock may begin again between two images") {
  ImageIntake intake(16, 16);
  ColourPicker picker(intake);
  picker.begin(1000.0 / 60.0, 32);
  send_colour(intake, 7, 0xFFFFFFF0U);
  CHECK(picker.pick(0x10, 34'000'000) != nullptr);
  picker.begin(1000.0, 64);
  CHECK(picker.pick(0x10, 34'000'000) == nullptr);
}
