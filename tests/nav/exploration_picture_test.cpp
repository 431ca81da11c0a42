// SPDX-License-Identifier: Apache-2.0
#include "nav/exploration_picture.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using nav::Canvas;
using nav::Cell;
using nav::CellState;
using nav::Colour;

namespace {

/// A known room of 4 x 2 m with a wall around it, in a much larger unknown floor.
struct Sample {
  Sample() : ground(0.05, -10.0, -10.0, 400, 400, CellState::unknown) {
    for (int y = 180; y < 220; ++y) {
      for (int x = 160; x < 240; ++x) {
        const bool is_edge = y == 180 || y == 219 || x == 160 || x == 239;
        ground.at({x, y}) = is_edge ? CellState::occupied : CellState::free;
      }
    }
    picture.ground = &ground;
    picture.home = {-1.5, -0.5, 0.0};
    picture.time_s = 30.0;
    picture.title = "sample";
    for (int i = 0; i <= 100; ++i) {
      hal::Pose pose;
      pose.translation_m = {-1.5 + 0.03 * i, -0.5, 0.5};
      way.push_back(pose);
    }
    for (int i = 0; i <= 30; ++i) curve.push_back({i * 1.0, i / 30.0, 0.1 * i});
  }
  nav::CellGrid<CellState> ground;
  std::vector<hal::Pose> way;
  std::vector<nav::CoverageSample> curve;
  nav::ExplorationPicture picture;
};

std::size_t differing(const Canvas& a, const Canvas& b) {
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < std::min(a.rgb().size(), b.rgb().size()); ++i) pixels += a.rgb()[i] != b.rgb()[i] ? 1 : 0;
  return pixels / 3;
}

/// Rows of the map panel that hold the wall's colour in the middle column, first and last.
std::pair<int, int> wall_rows(const Canvas& canvas) {
  const Colour wall{58, 63, 73};
  int first = -1, last = -1;
  for (int y = 0; y < canvas.size().height_px; ++y) {
    if (canvas.at(canvas.size().width_px / 2, y) != wall) continue;
    if (first < 0) first = y;
    last = y;
  }
  return {first, last};
}

}  // namespace

TEST_CASE("the picture shows the known part of the floor, to scale", "[nav][picture]") {
  const Sample sample;
  const Canvas canvas = draw_exploration(sample.picture);
  CHECK(canvas.size().width_px == 1200);
  const auto [first, last] = wall_rows(canvas);
  const double cell_px = 1140.0 / 88.0;  // 80 known cells and 4 on either side
  CHECK(last - first + 1 == Approx(40 * cell_px).margin(2.0));
}

TEST_CASE("way, frontiers and curve each leave their marks", "[nav][picture]") {
  Sample sample;
  const Canvas bare = draw_exploration(sample.picture);
  sample.picture.trajectory = sample.way;
  const Canvas with_way = draw_exploration(sample.picture);
  CHECK(differing(bare, with_way) > 1000);
  const std::vector<std::uint32_t> left{static_cast<std::uint32_t>(sample.ground.index({200, 200}))};
  sample.picture.frontier_cells = left;
  const Canvas with_frontier = draw_exploration(sample.picture);
  CHECK(differing(with_way, with_frontier) > 50);
  CHECK(differing(with_way, with_frontier) < 400);
  sample.picture.coverage = sample.curve;
  const Canvas whole = draw_exploration(sample.picture);
  CHECK(whole.size().height_px > bare.size().height_px + 200);
  CHECK(differing(with_frontier, whole) < 50);  // the map stays as it was
}

TEST_CASE("x goes to the right and y up", "[nav][picture]") {
  Sample sample;
  const Canvas before = draw_exploration(sample.picture);
  const std::vector<std::uint32_t> left{static_cast<std::uint32_t>(sample.ground.index({230, 215}))};  // upper right
  sample.picture.frontier_cells = left;
  const Canvas after = draw_exploration(sample.picture);
  for (int y = 0; y < after.size().height_px; ++y) {
    for (int x = 0; x < after.size().width_px; ++x) {
      if (after.at(x, y) == before.at(x, y)) continue;
      REQUIRE(x > 900);
      REQUIRE(y < 250);
    }
  }
}

TEST_CASE("a map of which nothing is known, or very much, can be drawn as well", "[nav][picture]") {
  Sample sample;
  sample.picture.coverage = sample.curve;
  nav::CellGrid<CellState> nothing(0.05, 0.0, 0.0, 50, 50, CellState::unknown);
  sample.picture.ground = &nothing;
  CHECK(draw_exploration(sample.picture).size().height_px > 300);
  nav::CellGrid<CellState> tall(0.05, 0.0, 0.0, 20, 4000, CellState::free);
  sample.picture.ground = &tall;
  CHECK(draw_exploration(sample.picture).size().height_px < 1200);
  sample.curve.assign(1, {0.0, 0.0, 0.0});
  sample.picture.coverage = sample.curve;
  sample.picture.time_s = 0.0;
  CHECK(draw_exploration(sample.picture).size().height_px < 1200);
}

TEST_CASE("it is written as a PNG, and a folder in its place is an error", "[nav][picture]") {
  const Sample sample;
  const test::TempFolder folder;
  const auto bytes = nav::write_exploration_picture(sample.picture, folder / "x.png");
  REQUIRE(bytes.ok());
  CHECK(bytes.value() == std::filesystem::file_size(folder / "x.png"));
  CHECK(test::read_plain(folder / "x.png").substr(1, 3) == "PNG");
  std::filesystem::create_directories(folder / "y.png/in_the_way");
  const auto failed = nav::write_exploration_picture(sample.picture, folder / "y.png");
  REQUIRE_FALSE(failed.ok());
  CHECK(failed.error().text.find("y.png") != std::string::npos);
}
