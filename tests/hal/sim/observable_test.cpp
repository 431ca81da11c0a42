// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/observable.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

struct Truth {
  explicit Truth(const std::string& text, const PlanarPose& start = {}, const ObservableOptions& options = {})
      : all(find_observable(parse_world(text, "w").value(), std::span(&start, 1), options).value()) {}
  [[nodiscard]] SeenCell at(double x_m, double y_m) const {
    return all.cells[all.frame.index(all.frame.column_of(x_m), all.frame.row_of(y_m))];
  }
  Observable all;
};

const std::string kRoom = "room 0 0 0  6 6 2.5 0.1\n";

}  // namespace

TEST_CASE("all of an empty room can be seen, its walls from inside, nothing beyond", "[slow]") {
  const Truth truth(kRoom);
  CHECK(truth.all.free_count == 120 * 120);
  for (double v = -2.97; v < 3.0; v += 0.05) {
    REQUIRE(truth.at(v, 0.51) == SeenCell::free);
    REQUIRE(truth.at(3.02, v) == SeenCell::wall);
    REQUIRE(truth.at(v, -3.02) == SeenCell::wall);
    REQUIRE(truth.at(3.07, v) == SeenCell::not_observable);
  }
  CHECK(truth.all.wall_count >= 4 * 120);
  CHECK(truth.all.wall_count <= 4 * 122);
}

TEST_CASE("only what lies between 0.8 and 3.5 m of reachable places counts") {
  // A corridor of 20 m behind a fence of poles: seen up to 3.5 m from the fence.
  std::string fence = "room 0 0 0  20 2 2.5 0.1\n";
  for (int i = 0; i < 7; ++i) fence += "pole -5 " + std::to_string(-0.9 + 0.3 * i) + " 0 0.02 2\n";
  const Truth truth(fence, {-8, 0, 0});
  CHECK(truth.at(-6, 0) == SeenCell::free);
  CHECK(truth.at(-2.2, 0) == SeenCell::free);
  CHECK(truth.at(-1.4, 0) == SeenCell::not_observable);
  // A closet in which the robot can only turn sees nothing that is near.
  const Truth closet("room 0 0 0  0.5 0.5 2.5 0.1\n");
  CHECK(closet.all.reachable_count > 0);
  CHECK(closet.all.count() == 0);
}

TEST_CASE("a high box hides what is behind it, a low one only partly, a table nothing", "[slow]") {
  const std::string wall = "box 0 0 0  6 0.1 2\n";
  const Truth hidden(kRoom + wall, {0, -1.5, 0});
  CHECK(hidden.at(0, 1.5) == SeenCell::not_observable);
  CHECK(hidden.at(0, -0.03) == SeenCell::wall);
  const Truth fence(kRoom + "box 0 0 0  6 0.1 0.3\n", {0, -1.5, 0});
  CHECK(fence.at(0, 1.5) == SeenCell::free);  // seen over it at up to 0.6 m
  CHECK(fence.at(0, -0.03) == SeenCell::wall);
  const Truth table(kRoom + "box 0 0 0.7  6 2 0.05\n", {0, -1.5, 0});
  CHECK(table.at(0, 0) == SeenCell::free);
}

TEST_CASE("black is never seen, glass is looked through but not driven through") {
  const Truth black(kRoom + "box 0 0 0  6 0.1 2 dark\n", {0, -1.5, 0});
  CHECK(black.at(0, -0.03) == SeenCell::not_observable);
  CHECK(black.at(0, 1.5) == SeenCell::not_observable);
  const Truth glass(kRoom + "box 0 0 0  6 0.02 2 glass\n", {0, -1.5, 0});
  CHECK(glass.at(0, 1.0) == SeenCell::free);
  CHECK(glass.at(1, 3.02) == SeenCell::wall);
  CHECK(glass.all.reachable_count < 9.0 * 5.64 / 0.0025 / 3.0);
}

TEST_CASE("a level surface just below the camera gives no reading, its edge does", "[slow]") {
  const Truth truth(kRoom + "box 0 1.5 0  6 3 0.45\n", {0, -1.5, 0});
  CHECK(truth.at(0, 0.02) == SeenCell::wall);
  CHECK(truth.at(0, 2.0) == SeenCell::not_observable);
  const Truth step(kRoom + "box 0 1.5 0  6 3 0.15\n", {0, -1.5, 0});
  CHECK(step.at(0, 1.5) == SeenCell::wall);
}

TEST_CASE("people are left out, a hole has no free cells", "[slow]") {
  const Truth truth(kRoom + "person 1.8 0.25 0,1,1\n");
  CHECK(truth.at(1, 1) == SeenCell::free);
  const Truth hole("floor -2 0 0  4 4 0.1\nfloor 3 0 0  2 4 0.1\n", {-2, 0, 0});
  CHECK(hole.at(-0.5, 0) == SeenCell::free);
  CHECK(hole.at(1.0, 0) == SeenCell::not_observable);
}

TEST_CASE("coverage is the known share of what is observable", "[slow]") {
  const Truth truth(kRoom);
  CHECK(coverage(truth.all, [](double, double, SeenCell) { return true; }) == 1.0);
  CHECK(coverage(truth.all, [](double, double, SeenCell) { return false; }) == 0.0);
  CHECK(coverage(truth.all, [](double x_m, double, SeenCell) { return x_m < 0.0; }) == Approx(0.5).margin(0.001));
  CHECK(coverage(Truth("room 0 0 0  0.5 0.5 2.5 0.1\n").all, [](double, double, SeenCell) { return false; }) == 1.0);
}
