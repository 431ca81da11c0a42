// SPDX-License-Identifier: Apache-2.0
#include "tests/support/offline_tour.hpp"

#include <algorithm>
#include <cmath>

#include "tests/support/flat_driver.hpp"
#include "tests/support/tour_plan.hpp"

namespace g3d::tests {

using nav::Cell;
using nav::CellGrid;
using Mask = CellGrid<std::uint8_t>;

namespace {

TourPlace look_from(const Mask& solid, const Mask& observable, Cell at) {
  constexpr int kDirections = 512;
  TourPlace place;
  const double x = place.x_m = solid.centre_x_m(at);
  const double y = place.y_m = solid.centre_y_m(at);
  std::vector<std::uint32_t> ray;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = (k + 0.5) * (6.283185307179586 / kDirections);
    ray.clear();
    double hit = 1e9;
    walk_ray(solid, x, y, std::cos(angle), std::sin(angle), 3.5, [&](std::size_t i, double distance) {
      if (observable.cells[i]) ray.push_back(static_cast<std::uint32_t>(i));
      if (!solid.cells[i]) return true;
      hit = distance;
      return false;
    });
    if (hit < 0.8) continue;
    for (const std::uint32_t i : ray) {
      place.cells.push_back(i);
      place.bearing.push_back(static_cast<std::uint8_t>(k * kTourBearings / kDirections));
    }
  }
  return place;
}

std::vector<TourPlace> look_everywhere(const Mask& solid, const Mask& reachable, const Mask& observable) {
  std::vector<TourPlace> places;
  for (int y = 4; y < solid.rows; y += 8) {
    for (int x = 4; x < solid.columns; x += 8) {
      // The reachable cell nearest to the lattice point, so that narrow places are not missed.
      for (int ring = 0; ring < 16; ++ring) {
        const Cell c{x + ring % 4 - 2, y + ring / 4 - 2};
        if (!solid.contains(c) || !reachable.at(c)) continue;
        places.push_back(look_from(solid, observable, c));
        break;
      }
    }
  }
  return places;
}

}  // namespace

FlatResult run_offline_tour(FlatSim& sim, const FlatWorld& world, const Mask& reachable, const Mask& observable,
                            double share) {
  FlatResult result;
  std::vector<std::uint8_t> covered(observable.cells.size(), 0);
  for (std::size_t i = 0; i < covered.size(); ++i) covered[i] = sim.ground().cells[i] != nav::CellState::unknown;
  const std::vector<TourView> views =
      choose_views(look_everywhere(world.solid, reachable, observable), observable.cells, std::move(covered), share);
  std::vector<hal::PlanarPose> poses{sim.pose()};
  for (const TourView& view : views) poses.push_back(view.pose);
  const Mask costs = true_costs(world.solid);
  FlatDriver driver(sim, false);
  for (const std::size_t stop : order_views(costs, kBodyRadius_m, poses)) {
    if (stop == 0) continue;
    const auto& cells = views[stop - 1].cells;
    const auto all_seen = [&] {
      return std::all_of(cells.begin(), cells.end(),
                         [&](std::uint32_t i) { return sim.ground().cells[i] != nav::CellState::unknown; });
    };
    if (all_seen()) continue;
    driver.set_goal(poses[stop], &costs);
    ++result.goals;
    while (driver.step() == DriveState::driving) {
      note_progress(sim, result);
      if (all_seen()) break;
    }
  }
  result.ended = true;
  note_end(sim, result);
  return result;
}

}  // namespace g3d::tests
