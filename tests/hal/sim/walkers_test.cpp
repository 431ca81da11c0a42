// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/walkers.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

void walk(Walkers& walkers, double duration_s, std::span<const std::array<float, 2>> robots) {
  for (int i = 0; i < static_cast<int>(duration_s / 0.01 + 0.5); ++i) walkers.step(0.01, robots, 0.18);
}

}  // namespace

TEST_CASE("who begins where he ends walks on and on, others stay at the end") {
  const World world = parse_world("person 1.8 0.2  0,0,0 4,4,0 8,0,0\nperson 1.8 0.2  1,0,5 3,2,5\n", "w").value();
  Walkers walkers(world, 2);
  walk(walkers, 2.0, {});
  CHECK(walkers.place_m(0)[0] == Approx(2.0).margin(0.02));
  CHECK(walkers.place_m(1)[0] == Approx(1.0).margin(0.02));
  walk(walkers, 16.0, {});
  CHECK(walkers.place_m(0)[0] == Approx(2.0).margin(0.02));
  CHECK(walkers.place_m(1)[0] == Approx(2.0).margin(1e-5));
}

TEST_CASE("a person stops before a robot, waits and then goes back") {
  const World world = parse_world("person 1.8 0.2  0,0,0 10,10,0 20,0,0\n", "w").value();
  Walkers walkers(world, 1);
  const std::array<std::array<float, 2>, 1> robot = {{{4.0F, 0.0F}}};
  double nearest = 1e9;
  for (int i = 0; i < 550; ++i) {
    walkers.step(0.01, robot, 0.18);
    nearest = std::min(nearest, std::abs(double{walkers.place_m(0)[0]} - 4.0));
  }
  CHECK(nearest >= 0.2 + 0.18 + 0.4 - 1e-6);
  CHECK(nearest < 0.2 + 0.18 + 0.4 + 0.02);
  walk(walkers, 2.0, robot);  // patience was over at about 6.2 s
  CHECK(walkers.place_m(0)[0] < 2.8F);
  walk(walkers, 10.0, {});
  CHECK(std::isfinite(walkers.place_m(0)[0]));
}

TEST_CASE("a robot behind somebody does not hold him") {
  const World world = parse_world("person 1.8 0.2  0,0,0 10,10,0\n", "w").value();
  Walkers walkers(world, 1);
  const std::array<std::array<float, 2>, 1> robot = {{{-0.5F, 0.0F}}};
  walk(walkers, 5.0, robot);
  CHECK(walkers.place_m(0)[0] == Approx(5.0).margin(0.02));
}
