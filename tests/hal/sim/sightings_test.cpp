// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sightings.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "hal/sim/world_file.hpp"

using namespace g3d;

namespace {

/// A closed room of 6 x 4 m with a pillar in its middle.
struct Scene {
  hal::World world = hal::parse_world("room 0 0 0  6 4 2.5 0.1\nbox 0 0 0  0.6 0.6 2\n", "w").value();
  hal::PlanFrame frame = hal::plan_frame(world).value();
  hal::Sightings sightings{world, frame, {}};

  [[nodiscard]] std::set<std::size_t> seen_from(double x_m, double y_m) const {
    std::set<std::size_t> seen;
    sightings.look_from(frame.column_of(x_m), frame.row_of(y_m), [&](std::size_t, std::size_t i) { seen.insert(i); });
    return seen;
  }
  [[nodiscard]] std::size_t at(double x_m, double y_m) const {
    return frame.index(frame.column_of(x_m), frame.row_of(y_m));
  }
};

}  // namespace

TEST_CASE("A place sees the floor and the walls within the camera's range, nothing nearer, nothing farther") {
  const Scene scene;
  const auto seen = scene.seen_from(-2.0, 0.0);
  CHECK(seen.count(scene.at(-1.0, 0.0)) == 1);
  CHECK(seen.count(scene.at(-1.6, 0.0)) == 0);  // 0.4 m
  CHECK(seen.count(scene.at(-2.0, 2.02)) == 1);
  CHECK(scene.sightings.is_wall(scene.at(-2.0, 2.02)));
  CHECK(seen.count(scene.at(2.0, 1.0)) == 0);  // 4.1 m
}

TEST_CASE("What stands behind something is hidden, its front is seen") {
  const Scene scene;
  const auto seen = scene.seen_from(-2.0, 0.0);
  CHECK(seen.count(scene.at(-0.27, 0.02)) == 1);
  CHECK(scene.sightings.is_wall(scene.at(-0.27, 0.02)));
  CHECK(seen.count(scene.at(1.0, 0.0)) == 0);
  CHECK(scene.seen_from(2.0, 0.0).count(scene.at(1.0, 0.0)) == 1);
}

TEST_CASE("Each cell is seen by a ray that points at it") {
  const Scene scene;
  const double x_m = -1.5, y_m = 1.0;
  const int column = scene.frame.column_of(x_m), row = scene.frame.row_of(y_m);
  double worst_rad = 0.0;
  std::set<std::size_t> rays;
  scene.sightings.look_from(column, row, [&](std::size_t ray, std::size_t index) {
    const int c = static_cast<int>(index) % scene.frame.columns;
    const int r = static_cast<int>(index) / scene.frame.columns;
    const double ray_rad =
        static_cast<double>(ray) * 6.283185307179586 / static_cast<double>(scene.sightings.ray_count());
    worst_rad =
        std::max(worst_rad, std::abs(std::remainder(std::atan2(r - row, c - column) - ray_rad, 6.283185307179586)));
    rays.insert(ray);
  });
  CHECK(worst_rad < 0.05);
  CHECK(rays.size() > 0.5 * static_cast<double>(scene.sightings.ray_count()));
}
