// SPDX-License-Identifier: Apache-2.0
#include "nav/team_claims.hpp"

#include <algorithm>
#include <cmath>

#include "nav/team_bodies.hpp"

namespace g3d::nav {
namespace {

double away_m(const CellGrid<CellState>& ground, Cell c, double x_m, double y_m) {
  return std::hypot(ground.centre_x_m(c) - x_m, ground.centre_y_m(c) - y_m);
}

}  // namespace

void TeamClaims::take(const TeamSight& sight, hal::TimeNs now) {
  has_team_ = sight.count > 0;
  assigned_ = sight.count > 0 ? sight.assigned : std::nullopt;
  count_ = 0;
  for (std::size_t i = 0; i < sight.count; ++i) {
    const Teammate& mate = sight.mates[i];
    if (!mate.has_goal || now >= mate.told_ns + kClaimHolds_ns) continue;
    claims_[count_++] = {mate.goal.x_m, mate.goal.y_m, mate.robot < sight.self};
  }
}

bool TeamClaims::is_near_any(double x_m, double y_m, bool of_first_alone) const {
  return std::any_of(claims_.begin(), claims_.begin() + static_cast<std::ptrdiff_t>(count_), [&](const Claim& claim) {
    return (claim.is_first || !of_first_alone) && std::hypot(claim.x_m - x_m, claim.y_m - y_m) < kApart_m;
  });
}

void TeamClaims::mark_around(const Claim& claim, const CellGrid<CellState>& ground, TourSearch& search,
                             SetAside& aside) const {
  const Cell at = ground.cell_of(claim.x_m, claim.y_m);
  if (!ground.contains(at) || ground.at(at) != CellState::free) return;
  for (const RayGain& ray : search.look_around(ground, at)) {
    if (ray.entry != RayGain::kNothing) aside.claim(search.targets().of_cell(ray.entry));
  }
}

void TeamClaims::mark(const CellGrid<CellState>& ground, TourSearch& search, SetAside& aside,
                      const std::optional<Own>& own) const {
  aside.forget_claims();
  for (std::size_t i = 0; i < count_; ++i) {
    if (!claims_[i].is_first) mark_around(claims_[i], ground, search, aside);
  }
  if (count_ > 0 && own) {
    for (const RayGain& ray : search.look(ground, own->cell, own->first_bearing)) {
      if (ray.entry != RayGain::kNothing) aside.unclaim(search.targets().of_cell(ray.entry));
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    if (claims_[i].is_first) mark_around(claims_[i], ground, search, aside);
  }
}

const View* TeamClaims::assigned(const CellGrid<CellState>& ground, const TourSearch& search,
                                 std::span<const View> views) const {
  if (!assigned_) return nullptr;
  for (const View& view : views) {
    if (away_m(ground, search.place(view).cell, assigned_->x_m, assigned_->y_m) < kAssigned_m) return &view;
  }
  return nullptr;
}

bool TeamClaims::wants_other_than(double x_m, double y_m) const {
  return assigned_ && std::hypot(assigned_->x_m - x_m, assigned_->y_m - y_m) >= kAssigned_m;
}

void TourOffers::take(const CellGrid<CellState>& ground, const TourSearch& search, const hal::PlanarPose& robot) {
  count = 0;
  for (const View& view : search.views()) {
    if (count == kMostOffers) return;
    const Cell cell = search.place(view).cell;
    const hal::PlanarPose goal{ground.centre_x_m(cell), ground.centre_y_m(cell), view.heading_rad};
    const bool is_same = std::any_of(
        offers.begin(), offers.begin() + static_cast<std::ptrdiff_t>(count),
        [&](const Offer& other) { return away_m(ground, cell, other.goal.x_m, other.goal.y_m) < kDistinct_m; });
    if (is_same) continue;
    offers[count++] = {goal, static_cast<float>(search.seconds_to(view, robot)), view.gain_cells};
  }
}

}  // namespace g3d::nav
