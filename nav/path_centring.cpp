// SPDX-License-Identifier: Apache-2.0
#include "nav/path_centring.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr int kSteps = 8;            // to either side
constexpr double kBetter_m = 0.002;  // nothing moves for less
constexpr std::size_t kAcross = 3;   // points before and behind that give the direction of the path

}  // namespace

double clearance_to_squares_m(const CellGrid<std::uint8_t>& cost, const Waypoint& at, double reach_m) {
  const Cell low = cost.cell_of(at.x_m - reach_m, at.y_m - reach_m);
  const Cell high = cost.cell_of(at.x_m + reach_m, at.y_m + reach_m);
  const double half_m = 0.5 * cost.resolution_m;
  double nearest_m2 = reach_m * reach_m;
  for (int y = std::max(low.y, 0); y <= std::min(high.y, cost.rows - 1); ++y) {
    for (int x = std::max(low.x, 0); x <= std::min(high.x, cost.columns - 1); ++x) {
      if (cost.at({x, y}) != kLethalCost) continue;
      const double dx = std::max(std::fabs(cost.centre_x_m({x, y}) - at.x_m) - half_m, 0.0);
      const double dy = std::max(std::fabs(cost.centre_y_m({x, y}) - at.y_m) - half_m, 0.0);
      nearest_m2 = std::min(nearest_m2, dx * dx + dy * dy);
    }
  }
  return std::sqrt(nearest_m2);
}

void centre_path(const CellGrid<std::uint8_t>& cost, std::span<Waypoint> path, double wide_m) {
  if (path.size() < 3) return;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Waypoint here = path[i];
    const Waypoint& before = path[i - std::min(i, kAcross)];
    const Waypoint& ahead = path[std::min(i + kAcross, path.size() - 1)];
    const double length_m = std::hypot(ahead.x_m - before.x_m, ahead.y_m - before.y_m);
    if (length_m < 1e-6) continue;
    const double left_x = -(ahead.y_m - before.y_m) / length_m;
    const double left_y = (ahead.x_m - before.x_m) / length_m;
    double best_m = clearance_to_squares_m(cost, here, wide_m);
    if (best_m >= wide_m) continue;
    for (int k = 1; k <= kSteps; ++k) {
      for (const double side : {1.0, -1.0}) {
        const double off_m = side * k * cost.resolution_m / kSteps;
        const Waypoint moved{here.x_m + off_m * left_x, here.y_m + off_m * left_y};
        const double clearance_m = clearance_to_squares_m(cost, moved, wide_m);
        if (clearance_m < best_m + kBetter_m) continue;
        best_m = clearance_m;
        path[i] = moved;
      }
    }
  }
}

}  // namespace g3d::nav
