// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/footprint_images.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper::cpu;

namespace {

/// Maximum of the ends in a square of pixels; what lies outside of the image counts as 0.
std::uint16_t slow_maximum(const RayEnds& ends, const hal::CameraModel& camera, int u0, int v0, int side_px) {
  std::uint16_t most = 0;
  for (int v = std::max(v0, 0); v < std::min(v0 + side_px, camera.height_px); ++v) {
    for (int u = std::max(u0, 0); u < std::min(u0 + side_px, camera.width_px); ++u)
      most = std::max(most, ends.at(u, v));
  }
  return most;
}

int wrong_cells(const FootprintImages& images, const RayEnds& ends, const hal::CameraModel& camera,
                FootprintImages::Choice choice) {
  const FootprintLevel& level = images.level(choice.level);
  const std::uint16_t* image = images.image(choice);
  int wrong = 0;
  for (int y = 1 - choice.window_cells; y < level.height; ++y) {
    for (int x = 1 - choice.window_cells; x < level.width; ++x) {
      const int scale = 1 << choice.level;
      const std::uint16_t expected = slow_maximum(ends, camera, x * scale, y * scale, choice.window_cells * scale);
      const std::uint16_t found = image[(y + kImagePadding) * level.stride + x + kImagePadding];
      wrong += found == expected ? 0 : 1;
    }
  }
  return wrong;
}

}  // namespace

TEST_CASE("every image that can be chosen holds the maximum of its window", "[threads]") {
  for (const int width : {20, 44, 84}) {
    hal::CameraModel camera = test::small_camera(width);
    camera.width_px -= 1;  // odd sizes leave half a cell at the border of every level
    const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
    for (const float smallest_px : {0.4F, 2.6F, 6.0F, 30.0F}) {
      ThreadPool pool(width == 44 ? 3 : 1);
      RayEnds ends(sensor, {}, 3000, true);
      FootprintImages images(camera.width_px, camera.height_px, smallest_px);
      for (std::uint64_t seed = 0; seed < 4; ++seed) {  // later frames overwrite the first
        // A frame that looks from nearer asks for no small windows: those need not be right.
        const float frame_smallest_px = std::array<float, 4>{smallest_px, 9.0F, 40.0F, smallest_px}[seed];
        const hal::Frame frame = test::random_frame(camera, seed);
        ends.compute(frame.depth.get(), best_kernels(), pool);
        images.compute(ends, best_kernels(), pool, frame_smallest_px);
        for (float size_px = std::max(smallest_px, frame_smallest_px); size_px < 400.0F; size_px *= 1.15F) {
          const FootprintImages::Choice choice = images.choose(size_px);
          INFO("level " << choice.level << " window " << choice.window_cells);
          REQUIRE(wrong_cells(images, ends, camera, choice) == 0);
        }
      }
    }
  }
}

TEST_CASE("the chosen window comes closest to the size that was asked for") {
  const FootprintImages images(640, 480, 1.0F);
  for (float size_px = 1.0F; size_px < 400.0F; size_px *= 1.01F) {
    const FootprintImages::Choice choice = images.choose(size_px);
    REQUIRE(choice.level < images.level_count());
    REQUIRE((choice.window_cells >= 1 && choice.window_cells <= kMaxWindow));
    const auto side_px = static_cast<float>(choice.window_cells << choice.level);
    const auto cell_px = static_cast<float>(1 << choice.level);
    REQUIRE(std::abs(side_px - size_px) <= 0.5F * cell_px + 1e-3F);
  }
  const FootprintImages::Choice largest = images.choose(1e6F);
  CHECK(largest.level == images.level_count() - 1);
  CHECK(largest.window_cells == kMaxWindow);
}

TEST_CASE("a covering window covers what was asked for, wherever its middle lies, and is one that is computed") {
  for (const float smallest_px : {1.0F, 5.0F, 9.0F}) {
    const FootprintImages images(640, 480, smallest_px);
    for (float size_px = smallest_px; size_px < 380.0F; size_px *= 1.07F) {
      const auto choice = images.covering(size_px);
      REQUIRE(choice);
      REQUIRE(choice->window_cells <= kMaxWindow);
      // From the second level on windows of 4 cells and more are computed, on the first those that were announced.
      REQUIRE(static_cast<float>(choice->window_cells) >= (choice->level > 0 ? 4.0F : smallest_px));
      const auto cell_px = static_cast<float>(1 << choice->level);
      const auto m = static_cast<float>(choice->window_cells);
      for (float u = 100.0F; u < 100.0F + cell_px; u += 0.23F) {
        const float begin = std::floor((u + 0.5F) / cell_px - 0.5F * m + 0.5F) * cell_px;
        REQUIRE(begin <= u + 0.5F - 0.5F * size_px);
        REQUIRE(begin + m * cell_px >= u + 0.5F + 0.5F * size_px);
      }
    }
    CHECK_FALSE(images.covering(1e4F));
  }
}

TEST_CASE("levels halve the image until nothing is left to halve") {
  const FootprintImages images(37, 5, 1.0F);
  REQUIRE(images.level_count() >= 3);
  CHECK(images.level(0).width == 37);
  CHECK(images.level(1).width == 19);
  CHECK(images.level(1).height == 3);
  CHECK(images.level(2).width == 10);
  CHECK(images.level(2).height == 2);
  for (int l = 0; l < images.level_count(); ++l)
    CHECK(images.level(l).stride >= images.level(l).width + 2 * kImagePadding);
}
