// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/render.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "hal/image/file_bytes.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

const hal::ImageSize kSize{320, 240};

/// Pixels for which `is_it(r, g, b)`.
template <typename Test>
int count(const std::vector<std::uint8_t>& rgb, Test is_it) {
  int found = 0;
  for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) found += is_it(rgb[i], rgb[i + 1], rgb[i + 2]) ? 1 : 0;
  return found;
}
bool is_sofa(int r, int g, int b) { return r > 2 * g && r > 2 * b && r > 90 && g > 25; }
bool is_ball(int r, int g, int b) { return b > 2 * r && b > g + 40; }
bool is_floor(int r, int g, int b) { return r > g + 20 && g > b + 20 && r < 2 * g; }
bool is_line(int r, int g, int b) { return r > 200 && g < 70 && b > 60 && b < 120; }

}  // namespace

TEST_CASE("The picture looks into the room: floor, sofa and ball are seen, the ceiling is not in the way") {
  const auto room = tests::furnished_room(0.05F);
  RenderOptions options;
  options.size = kSize;
  const auto rgb = render_perspective(*room, options);
  REQUIRE(rgb.size() == 3 * kSize.pixel_count());
  CHECK(count(rgb, is_floor) > 8000);
  CHECK(count(rgb, is_sofa) > 1000);
  CHECK(count(rgb, is_ball) > 40);
  const auto background = render_perspective(VoxelMap(Grid{0.1F}, {8, 8, 8}), options);
  int changed = 0;
  for (std::size_t i = 0; i < rgb.size(); i += 3) changed += rgb[i] != background[i] ? 1 : 0;
  CHECK(changed > static_cast<int>(kSize.pixel_count()) / 4);
  for (int x = 0; x < kSize.width_px; ++x)
    REQUIRE(rgb[3 * static_cast<std::size_t>(x)] == background[3 * static_cast<std::size_t>(x)]);  // nothing is cut off
}

TEST_CASE("A room mapped without free space is looked into as well") {
  RenderOptions options;
  options.size = kSize;
  const auto rgb = render_perspective(*tests::furnished_room(0.05F, false), options);
  CHECK(count(rgb, is_floor) > 2000);
}

TEST_CASE("The trajectory is drawn into both pictures") {
  const auto room = tests::furnished_room(0.1F);
  const std::vector<hal::Pose> walk{{{-1.5, -1.8, 1.2}, {0, 0, 0, 1}}, {{1.5, -1.8, 1.2}, {0, 0, 0, 1}}};
  RenderOptions options;
  options.size = kSize;
  CHECK(count(render_perspective(*room, options), is_line) == 0);
  CHECK(count(render_top(*room, options), is_line) == 0);
  options.trajectory = walk;
  CHECK(count(render_perspective(*room, options), is_line) > 60);
  CHECK(count(render_top(*room, options), is_line) > 60);
}

TEST_CASE("Pictures are written as files, and a bad path is an error") {
  std::string folder = (std::filesystem::temp_directory_path() / "g3d_render_XXXXXX").string();
  REQUIRE(mkdtemp(folder.data()) != nullptr);
  const auto room = tests::furnished_room(0.2F);
  RenderOptions options;
  options.size = kSize;
  CHECK(write_perspective(*room, folder + "/map.png", options).ok());
  CHECK(write_top(*room, folder + "/top.png", options).ok());
  CHECK(std::filesystem::file_size(folder + "/map.png") > 1000);
  CHECK_FALSE(write_perspective(*room, folder + "/none/map.png", options).ok());
  std::filesystem::remove_all(folder);
}
