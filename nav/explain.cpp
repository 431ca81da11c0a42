// SPDX-License-Identifier: Apache-2.0
#include "nav/explain.hpp"

#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kPlace_units = 5;

}  // namespace

void Explanation::reset(std::size_t targets) {
  seen_in_.assign(targets, 0);
  round_ = 0;
}

/// Free ground in line of sight, far enough to measure from: if the body does not get there, that is the reason.
bool Explanation::has_room_to_look_from(const CellGrid<CellState>& ground, Cell frontier, double near_m) const {
  constexpr int kDirections = 24;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = k * (6.283185307179586 / kDirections);
    const double dx = std::cos(angle);
    const double dy = std::sin(angle);
    for (double m = ground.resolution_m; m <= near_m + 0.3; m += ground.resolution_m) {
      const Cell c = ground.cell_of(ground.centre_x_m(frontier) + m * dx, ground.centre_y_m(frontier) + m * dy);
      if (!ground.contains(c) || ground.at(c) != CellState::free) break;
      if (m >= near_m) return true;
    }
  }
  return false;
}

FrontiersLeft Explanation::explain(const CellGrid<CellState>& ground, const FrontierMap& frontiers,
                                   const Targets& targets, const SetAside& aside, const Viewpoints& places,
                                   double near_m, bool any_open) {
  begin();
  WorkBudget budget = WorkBudget::unlimited();
  (void)note_seen(targets, places, budget);
  return name_reasons(ground, frontiers, targets, aside, near_m, any_open);
}

void Explanation::begin() {
  ++round_;
  next_ = 0;
}

bool Explanation::note_seen(const Targets& targets, const Viewpoints& places, WorkBudget& budget) {
  for (; next_ < places.useful().size(); ++next_) {
    if (budget.is_spent()) return false;
    budget.spend(kPlace_units);
    for (const RayGain& ray : places.place(places.useful()[next_]).gain) {
      if (ray.entry != RayGain::kNothing) seen_in_[targets.of_cell(ray.entry)] = round_;
    }
  }
  return true;
}

FrontiersLeft Explanation::name_reasons(const CellGrid<CellState>& ground, const FrontierMap& frontiers,
                                        const Targets& targets, const SetAside& aside, double near_m,
                                        bool any_open) const {
  FrontiersLeft left;
  for (const FrontierCluster& cluster : frontiers.clusters()) {
    bool inside = false;
    bool seen = false;
    bool untried = false;
    bool blocked = false;
    for (const std::uint32_t cell : frontiers.cells_of(cluster)) {
      const std::uint32_t target = targets.of_cell(cell);
      if (aside.is_excluded(target)) continue;
      inside = true;
      if (aside.is_given_up(target)) {
        blocked = blocked || aside.was_blocked(target);
        continue;
      }
      untried = true;
      seen = seen || seen_in_[target] == round_;
    }
    if (!inside) {
      ++left[LeftReason::outside_area];
    } else if (!untried) {
      ++left[blocked ? LeftReason::blocked : LeftReason::fruitless];
    } else if (seen) {
      if (any_open) {
        ++left.open;
      } else {
        ++left[LeftReason::too_small];
      }
    } else {
      const Cell middle = ground.cell(frontiers.cells_of(cluster)[cluster.count / 2]);
      ++left[has_room_to_look_from(ground, middle, near_m) ? LeftReason::unreachable : LeftReason::out_of_sight];
    }
  }
  return left;
}

}  // namespace g3d::nav
