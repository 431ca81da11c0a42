// SPDX-License-Identifier: Apache-2.0
#include "nav/team_cost.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kAroundBody_m = 0.20;      // beyond the body's radius
constexpr std::uint8_t kAroundCost = 160;   // where a robot would pass close by
constexpr std::size_t kMostStamped = 1024;  // cells of one body, at 5 cm some 600

}  // namespace

TeamCost::TeamCost(const CellGrid<std::uint8_t>& like) : cost_(like) {
  stamped_.reserve(kMostTeammates * kMostStamped);
}

void TeamCost::note_changed(const CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> cells) {
  if (!is_copied_) return;
  for (const std::uint32_t cell : cells) cost_.cells[cell] = cost.cells[cell];
  if (body_count_ > 0 && !cells.empty()) stamp(cost);
}

void TeamCost::stand(const CellGrid<std::uint8_t>& cost, std::span<const Body> bodies) {
  if (bodies.empty() && body_count_ == 0) return;
  if (!is_copied_) {
    cost_.cells = cost.cells;
    is_copied_ = true;
  }
  body_count_ = std::min(bodies.size(), bodies_.size());
  std::copy_n(bodies.begin(), body_count_, bodies_.begin());
  stamp(cost);
}

void TeamCost::stamp(const CellGrid<std::uint8_t>& cost) {
  for (const std::uint32_t cell : stamped_) cost_.cells[cell] = cost.cells[cell];
  stamped_.clear();
  for (std::size_t i = 0; i < body_count_; ++i) {
    const Body& body = bodies_[i];
    const double reach_m = body.radius_m + kAroundBody_m;
    const Cell low = cost.cell_of(body.x_m - reach_m, body.y_m - reach_m);
    const Cell high = cost.cell_of(body.x_m + reach_m, body.y_m + reach_m);
    for (int y = std::max(low.y, 0); y <= std::min(high.y, cost.rows - 1); ++y) {
      for (int x = std::max(low.x, 0); x <= std::min(high.x, cost.columns - 1); ++x) {
        const Cell c{x, y};
        const double away_m = std::hypot(cost.centre_x_m(c) - body.x_m, cost.centre_y_m(c) - body.y_m);
        if (away_m > reach_m || stamped_.size() == stamped_.capacity()) continue;
        const std::uint8_t added = away_m <= body.radius_m ? kInscribedCost : kAroundCost;
        std::uint8_t& here = cost_.at(c);
        if (here >= added && here != kUnknownCost) continue;
        if (here == kUnknownCost && added != kInscribedCost) continue;
        here = added;
        stamped_.push_back(static_cast<std::uint32_t>(cost.index(c)));
      }
    }
  }
}

}  // namespace g3d::nav
