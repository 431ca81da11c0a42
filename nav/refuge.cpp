// SPDX-License-Identifier: Apache-2.0
#include "nav/refuge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "nav/seconds.hpp"
#include "nav/step_costs.hpp"
#include "nav/team_bodies.hpp"

namespace g3d::nav {
namespace {

constexpr double kRefugeStep_s = 0.25;
constexpr std::size_t kRefugeSteps = 100;
constexpr double kRefugeSpare_m = 0.05;  // beyond what is needed to be passed
constexpr double kWayStep_m = 0.1;

}  // namespace

Refuge::Refuge(double resolution_m) : reach_cells_(static_cast<int>(kReach_m / resolution_m)) {
  const auto side = static_cast<std::size_t>(2 * reach_cells_ + 1);
  on_way_.resize(side * side);
  steps_.resize(side * side);
  queue_.reserve(side * side);
}

void Refuge::mark(const CellGrid<std::uint8_t>& cost, const Waypoint& at, double radius_m) {
  const Cell low = cost.cell_of(at.x_m - radius_m, at.y_m - radius_m);
  const Cell high = cost.cell_of(at.x_m + radius_m, at.y_m + radius_m);
  for (int y = std::max(low.y, centre_.y - reach_cells_); y <= std::min(high.y, centre_.y + reach_cells_); ++y) {
    for (int x = std::max(low.x, centre_.x - reach_cells_); x <= std::min(high.x, centre_.x + reach_cells_); ++x) {
      if (std::hypot(cost.centre_x_m({x, y}) - at.x_m, cost.centre_y_m({x, y}) - at.y_m) > radius_m) continue;
      on_way_[index(x - centre_.x, y - centre_.y)] = 1;
    }
  }
}

void Refuge::mark_ways(const CellGrid<std::uint8_t>& cost, const TeamSight& sight, hal::TimeNs now,
                       const RightOfWayConfig& config) {
  for (std::size_t i = 0; i < sight.count; ++i) {
    const Teammate& mate = sight.mates[i];
    if (!RightOfWay::goes_first(sight, mate, now)) continue;
    const double radius_m = config.body_radius_m + static_cast<double>(mate.radius_m) + config.pass_gap_m +
                            doubt_m(mate, now) + kRefugeSpare_m;
    Waypoint from = place_at(mate, now, now);
    mark(cost, from, radius_m);
    const double passed_s = mate.is_moving ? seconds_between(mate.told_ns, now) : 0.0;
    for (std::size_t k = 0; k < mate.way_count; ++k) {
      if (static_cast<double>(mate.way[k].after_s) < passed_s) continue;
      const Waypoint to{static_cast<double>(mate.way[k].x_m), static_cast<double>(mate.way[k].y_m)};
      const double length_m = std::min(std::hypot(to.x_m - from.x_m, to.y_m - from.y_m), 4.0 * kReach_m);
      for (double s = kWayStep_m; s < length_m; s += kWayStep_m) {
        const double part = s / length_m;
        mark(cost, {from.x_m + part * (to.x_m - from.x_m), from.y_m + part * (to.y_m - from.y_m)}, radius_m);
      }
      mark(cost, to, radius_m);
      from = to;
    }
  }
}

std::optional<hal::PlanarPose> Refuge::find(const CellGrid<std::uint8_t>& cost, const TeamSight& sight, hal::TimeNs now,
                                            const hal::PlanarPose& here, const RightOfWayConfig& config) {
  centre_ = cost.cell_of(here.x_m, here.y_m);
  if (!cost.contains(centre_)) return std::nullopt;
  std::fill(on_way_.begin(), on_way_.end(), std::uint8_t{0});
  std::fill(steps_.begin(), steps_.end(), std::uint16_t{0});
  mark_ways(cost, sight, now, config);

  // Where they will be, by time.
  std::array<std::array<Waypoint, kRefugeSteps>, kMostTeammates> theirs;
  std::array<double, kMostTeammates> apart_m{};
  std::size_t firsts = 0;
  for (std::size_t i = 0; i < sight.count; ++i) {
    const Teammate& mate = sight.mates[i];
    if (!RightOfWay::goes_first(sight, mate, now)) continue;
    for (std::size_t k = 0; k < kRefugeSteps; ++k) {
      theirs[firsts][k] = place_at(mate, now, after(now, static_cast<double>(k) * kRefugeStep_s));
    }
    const double now_m = std::hypot(theirs[firsts][0].x_m - here.x_m, theirs[firsts][0].y_m - here.y_m);
    const double bodies_m = config.body_radius_m + static_cast<double>(mate.radius_m) + doubt_m(mate, now);
    apart_m[firsts++] = std::min(bodies_m + 0.5 * config.gap_m, now_m - 0.01);
  }
  const int relief = StepOptions{}.relief_cells;
  const double step_s = cost.resolution_m / config.speed_mps;
  queue_.clear();
  queue_.push_back({0, 0});
  steps_[index(0, 0)] = 1;
  for (std::size_t i = 0; i < queue_.size(); ++i) {
    const Cell at = queue_[i];
    const std::uint16_t steps = steps_[index(at.x, at.y)];
    const Cell c{centre_.x + at.x, centre_.y + at.y};
    if (on_way_[index(at.x, at.y)] == 0 && cost.at(c) < kInscribedCost) {
      return hal::PlanarPose{cost.centre_x_m(c), cost.centre_y_m(c), here.heading_rad};
    }
    for (int direction = 0; direction < 4; ++direction) {
      const Cell to{at.x + kStepX[static_cast<std::size_t>(direction)],
                    at.y + kStepY[static_cast<std::size_t>(direction)]};
      if (std::max(std::abs(to.x), std::abs(to.y)) > reach_cells_) continue;
      const Cell next{centre_.x + to.x, centre_.y + to.y};
      std::uint16_t& met = steps_[index(to.x, to.y)];
      if (met != 0 || !cost.contains(next)) continue;
      const bool is_near = std::max(std::abs(to.x), std::abs(to.y)) <= relief;
      if (cost.at(next) > (is_near ? kInscribedCost : kInscribedCost - 1)) continue;
      met = static_cast<std::uint16_t>(steps + 1);
      const auto k = static_cast<std::size_t>(static_cast<double>(steps) * step_s / kRefugeStep_s);
      bool is_met = false;
      for (std::size_t m = 0; m < firsts && !is_met; ++m) {
        const Waypoint& they = theirs[m][std::min(k, kRefugeSteps - 1)];
        is_met = std::hypot(cost.centre_x_m(next) - they.x_m, cost.centre_y_m(next) - they.y_m) < apart_m[m];
      }
      if (!is_met) queue_.push_back(to);
    }
  }
  return std::nullopt;
}

}  // namespace g3d::nav
