// SPDX-License-Identifier: Apache-2.0
// What a robot on the floor meets: the nearest thing between two heights, and where there is no floor. Boxes, round
// solids, grid walls, people and other robots alike; glass is as solid as a wall here. Distances are exact in the
// plane, nothing is allocated after construction, and any number of threads may ask.
#pragma once

#include <cstdint>
#include <limits>

#include "hal/sim/plan_shape.hpp"
#include "hal/sim/solid_grid.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// A rug or threshold up to here is rolled over (Kobuki's data sheet: 12 mm; rugs of 20 mm).
inline constexpr double kClimb_m = 0.02;
/// Farther than this below the wheels there is no floor.
inline constexpr double kNoFloor_m = -1000.0;

class FloorContact {
 public:
  /// How far around a place is looked; what is farther away does not count.
  static constexpr double kReach_m = 0.6;

  enum class Kind : std::uint8_t { nothing, solid, grid };
  struct Thing {
    Kind kind = Kind::nothing;
    std::int32_t solid = -1;  ///< index in World::primitives
    std::int32_t mover = -1;  ///< that carries it
    PlanPoint at;             ///< its nearest point; distance at most kReach_m, infinite if there is nothing
  };

  /// `world` must outlive this.
  explicit FloorContact(const World& world);

  /// The nearest thing within kReach_m of (x, y) in the slice; the mover `hidden` does not count, nor do
  /// movers without a place.
  [[nodiscard]] Thing nearest(double x_m, double y_m, const HeightSlice& slice, MoverPlaces places_m,
                              std::int32_t hidden) const;
  /// visit(Thing) for everything nearer than `reach_m` (at most kReach_m).
  template <typename Visit>
  void for_near(double x_m, double y_m, double reach_m, const HeightSlice& slice, MoverPlaces places_m,
                std::int32_t hidden, const Visit& visit) const;
  /// Height of the highest surface that a wheel can stand on, kNoFloor_m if there is none.
  [[nodiscard]] double floor_m(double x_m, double y_m) const;

  [[nodiscard]] const World& world() const { return world_; }

 private:
  [[nodiscard]] PlanPoint nearest_of_cell(int i, int j, double x_m, double y_m) const;
  template <typename Visit>
  void for_near_cells(double x_m, double y_m, double reach_m, const HeightSlice& slice, const Visit& visit) const;

  const World& world_;
  SolidGrid obstacles_;
  SolidGrid floors_;
  std::vector<std::int32_t> moving_;
};

template <typename Visit>
void FloorContact::for_near(double x_m, double y_m, double reach_m, const HeightSlice& slice, MoverPlaces places_m,
                            std::int32_t hidden, const Visit& visit) const {
  for (const std::int32_t i : obstacles_.near(x_m, y_m)) {
    const PlanPoint at = nearest_in_plan(world_.primitives()[static_cast<std::size_t>(i)], slice, x_m, y_m);
    if (at.distance_m < reach_m) visit(Thing{Kind::solid, i, -1, at});
  }
  for (const std::int32_t i : moving_) {
    const std::int32_t mover = world_.primitives()[static_cast<std::size_t>(i)].mover;
    if (mover == hidden || static_cast<std::size_t>(mover) >= places_m.size()) continue;
    const PlanPoint at = nearest_in_plan(world_.placed(static_cast<std::size_t>(i), places_m), slice, x_m, y_m);
    if (at.distance_m < reach_m) visit(Thing{Kind::solid, i, mover, at});
  }
  if (world_.grid()) for_near_cells(x_m, y_m, reach_m, slice, visit);
}

template <typename Visit>
void FloorContact::for_near_cells(double x_m, double y_m, double reach_m, const HeightSlice& slice,
                                  const Visit& visit) const {
  const GridWalls& grid = *world_.grid();
  if (double{grid.z_low_m()} > slice.high_m || double{grid.z_high_m()} < slice.low_m) return;
  const double cell_m = grid.cell_m();
  const double u = (x_m - double{grid.origin_m()[0]}) / cell_m;
  const double v = (y_m - double{grid.origin_m()[1]}) / cell_m;
  const double reach_cells = reach_m / cell_m;
  const auto from = [&](double at) { return at - reach_cells > 0.0 ? static_cast<int>(at - reach_cells) : 0; };
  const auto to = [&](double at, int count) {
    return at + reach_cells < count - 1 ? static_cast<int>(at + reach_cells) : count - 1;
  };
  if (u + reach_cells < 0.0 || v + reach_cells < 0.0) return;
  if (u >= 0.0 && v >= 0.0 && u < grid.width_cells() && v < grid.height_cells()) {
    // No wall in a square of this many cells around: the nearest face is at least one cell less away.
    if (grid.distance(static_cast<int>(u), static_cast<int>(v)) - 1 > reach_cells) return;
  }
  for (int j = from(v); j <= to(v, grid.height_cells()); ++j) {
    for (int i = from(u); i <= to(u, grid.width_cells()); ++i) {
      if (!grid.is_solid_cell(i, j)) continue;
      const PlanPoint at = nearest_of_cell(i, j, x_m, y_m);
      if (at.distance_m < reach_m) visit(Thing{Kind::grid, -1, -1, at});
    }
  }
}

}  // namespace g3d::hal
