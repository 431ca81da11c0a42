// SPDX-License-Identifier: Apache-2.0
#include "hal/image/image_size.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("Pixel counts do not overflow, and wrong sizes are told apart") {
  CHECK(ImageSize{100'000, 100'000}.pixel_count() == 10'000'000'000ULL);
  const Error error = wrong_size_error("a.png", {320, 240}, {640, 480});
  CHECK(error.reason == Reason::out_of_range);
  CHECK(error.text.find("a.png: is 320x240") == 0);
}
