// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/floor_contact.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

std::vector<std::int32_t> select(const World& world, bool moving, bool floor) {
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < world.primitives().size(); ++i) {
    const Primitive& p = world.primitives()[i];
    if ((p.mover >= 0) == moving && (moving || (upper_side_m(p) <= kClimb_m) == floor)) {
      out.push_back(static_cast<std::int32_t>(i));
    }
  }
  return out;
}

}  // namespace

FloorContact::FloorContact(const World& world)
    : world_(world),
      obstacles_(world, select(world, false, false), kReach_m),
      floors_(world, select(world, false, true), 0.0),
      moving_(select(world, true, false)) {}

FloorContact::Thing FloorContact::nearest(double x_m, double y_m, const HeightSlice& slice, MoverPlaces places_m,
                                          std::int32_t hidden) const {
  Thing best;
  for_near(x_m, y_m, kReach_m, slice, places_m, hidden, [&](const Thing& thing) {
    if (thing.at.distance_m < best.at.distance_m) best = thing;
  });
  return best;
}

double FloorContact::floor_m(double x_m, double y_m) const {
  double highest_m = kNoFloor_m;
  for (const std::int32_t i : floors_.near(x_m, y_m)) {
    const Primitive& p = world_.primitives()[static_cast<std::size_t>(i)];
    const double top_m = upper_side_m(p);
    if (top_m <= highest_m) continue;
    if (nearest_in_plan(p, {underside_m(p), top_m}, x_m, y_m).distance_m == 0.0) highest_m = top_m;
  }
  return highest_m;
}

PlanPoint FloorContact::nearest_of_cell(int i, int j, double x_m, double y_m) const {
  const GridWalls& grid = *world_.grid();
  const double low_x = double{grid.origin_m()[0]} + i * double{grid.cell_m()};
  const double low_y = double{grid.origin_m()[1]} + j * double{grid.cell_m()};
  const double x = std::clamp(x_m, low_x, low_x + double{grid.cell_m()});
  const double y = std::clamp(y_m, low_y, low_y + double{grid.cell_m()});
  return {std::sqrt((x_m - x) * (x_m - x) + (y_m - y) * (y_m - y)), x, y};
}

}  // namespace g3d::hal
