// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tour_chooser.hpp"

#include <algorithm>
#include <cmath>

#include "hal/sim/sightings.hpp"
#include "nav/coverage.hpp"
#include "nav/inflation.hpp"
#include "nav/surroundings.hpp"

namespace g3d::tests {
namespace {

constexpr int kLattice_cells = 8;
constexpr double kPoint_m = 0.02;  // what does not fit on a cell's middle stands there

/// The reachable cell nearest to a lattice point, so that narrow places are not missed.
bool nearest_reachable(const hal::Observable& o, int column, int row, int& at_column, int& at_row) {
  for (int ring = 0; ring <= kLattice_cells / 2; ++ring) {
    for (int dy = -ring; dy <= ring; ++dy) {
      for (int dx = -ring; dx <= ring; ++dx) {
        if (std::max(std::abs(dx), std::abs(dy)) != ring) continue;
        at_column = column + dx;
        at_row = row + dy;
        if (o.frame.contains(at_column, at_row) && o.reachable[o.frame.index(at_column, at_row)] != 0) return true;
      }
    }
  }
  return false;
}

}  // namespace

BuildingPlan survey(const hal::World& world, const hal::Observable& observable, const nav::NavigatorConfig& config) {
  BuildingPlan plan;
  plan.observable = observable;
  const hal::PlanFrame& frame = observable.frame;
  const hal::Sightings sightings(world, frame, {});
  for (int row = kLattice_cells / 2; row < frame.rows; row += kLattice_cells) {
    for (int column = kLattice_cells / 2; column < frame.columns; column += kLattice_cells) {
      int c = 0;
      int r = 0;
      if (!nearest_reachable(observable, column, row, c, r)) continue;
      TourPlace place;
      place.x_m = frame.x_m(c);
      place.y_m = frame.y_m(r);
      sightings.look_from(c, r, [&](std::size_t ray, std::size_t cell) {
        if (observable.cells[cell] == hal::SeenCell::not_observable) return;
        place.cells.push_back(static_cast<std::uint32_t>(cell));
        place.bearing.push_back(static_cast<std::uint8_t>(ray * kTourBearings / sightings.ray_count()));
      });
      plan.places.push_back(std::move(place));
    }
  }
  const hal::FloorContact floor(world);
  nav::CellGrid<nav::CellState> states{
      frame.cell_m, frame.first_x * frame.cell_m, frame.first_y * frame.cell_m, frame.columns,
      frame.rows,   nav::CellState::free};
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      hal::ReachOptions point;
      point.radius_m = kPoint_m;
      if (!hal::fits(floor, frame.x_m(column), frame.y_m(row), point)) {
        states.cells[frame.index(column, row)] = nav::CellState::occupied;
      }
    }
  }
  nav::Inflation inflation(states, {nav::planning_radius_m(config.follower.limits.body_radius_m, frame.cell_m),
                                    config.inflation_radius_m, config.inflation_decay_perm});
  inflation.rebuild(states);
  plan.cost = inflation.cost();
  return plan;
}

bool TourChooser::is_known(const nav::CellGrid<nav::CellState>& ground, std::uint32_t cell) const {
  const hal::PlanFrame& frame = plan_.observable.frame;
  const int column = static_cast<int>(cell) % frame.columns;
  const int row = static_cast<int>(cell) / frame.columns;
  return nav::CoverageMeter::is_known(ground, frame.x_m(column), frame.y_m(row), plan_.observable.cells[cell]);
}

void TourChooser::plan_round(const nav::CellGrid<nav::CellState>& ground, const hal::PlanarPose& T_world_base) {
  ++rounds_;
  next_ = 0;
  views_.clear();
  std::vector<std::uint8_t> wanted(plan_.observable.cells.size());
  std::vector<std::uint8_t> covered(wanted.size());
  for (std::uint32_t i = 0; i < wanted.size(); ++i) {
    wanted[i] = plan_.observable.cells[i] != hal::SeenCell::not_observable ? 1 : 0;
    covered[i] = wanted[i] != 0 && is_known(ground, i) ? 1 : 0;
  }
  std::vector<TourView> views = choose_views(plan_.places, wanted, std::move(covered), kShare);
  std::vector<hal::PlanarPose> poses{T_world_base};
  for (const TourView& view : views) poses.push_back(view.pose);
  for (const std::size_t stop : order_views(plan_.cost, body_radius_m_, poses)) {
    if (stop != 0) views_.push_back(std::move(views[stop - 1]));
  }
}

std::optional<nav::Decision> TourChooser::decide(const nav::CellGrid<nav::CellState>& ground,
                                                 const nav::CellGrid<std::uint8_t>&, std::span<const std::uint32_t>,
                                                 const hal::PlanarPose& T_world_base, hal::TimeNs) {
  nav::Decision decision;  // done
  if (rounds_ == 0) plan_round(ground, T_world_base);
  while (rounds_ <= kRounds) {
    for (; next_ < views_.size(); ++next_, is_new_ = true, is_over_ = false) {
      const auto& cells = views_[next_].cells;
      if (is_over_ || std::all_of(cells.begin(), cells.end(), [&](std::uint32_t i) { return is_known(ground, i); })) {
        continue;
      }
      decision.kind = nav::DecisionKind::goal;
      decision.goal = views_[next_].pose;
      decision.is_new = is_new_;
      is_new_ = false;
      return decision;
    }
    if (rounds_ == kRounds) break;
    plan_round(ground, T_world_base);
  }
  return decision;
}

void drive_tour(nav::NavigatorConfig& config, const BuildingPlan& plan) {
  const double radius_m = config.follower.limits.body_radius_m;
  config.make_chooser = [&plan, radius_m](const nav::ExplorerConfig&) {
    return std::make_unique<TourChooser>(plan, radius_m);
  };
  config.decide_period_s = 0.1;
  config.is_steadfast = false;
  config.pursuit.known_cost = &plan.cost;
}

}  // namespace g3d::tests
