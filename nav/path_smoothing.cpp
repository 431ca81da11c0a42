// SPDX-License-Identifier: Apache-2.0
#include "nav/path_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "nav/step_costs.hpp"

namespace g3d::nav {
namespace {

constexpr std::size_t kPatience_cells = 40;  // how far beyond the last possible shortcut another one is looked for
constexpr std::size_t kTrials = 16;          // long stretches are tried in steps of this part of their length
constexpr double kTolerance = 1.0 + 1e-9;    // equal costs summed in another order

double weight_of(std::uint8_t cost) { return kStraightCost + 0.8 * cost; }

std::uint8_t known_cost(const CellGrid<std::uint8_t>& cost, Cell c, std::uint8_t unknown_as) {
  const std::uint8_t value = cost.at(c);
  return value == kUnknownCost ? unknown_as : value;
}

}  // namespace

LineCost cost_of_line(const CellGrid<std::uint8_t>& cost, Cell from, Cell to, std::uint8_t unknown_as) {
  if (!cost.contains(from) || !cost.contains(to)) return {kUnknownCost, 0.0};
  const std::int64_t columns = std::abs(to.x - from.x);
  const std::int64_t rows = std::abs(to.y - from.y);
  const int step_x = to.x > from.x ? 1 : -1;
  const int step_y = to.y > from.y ? 1 : -1;
  std::uint8_t costliest = 0;
  double weights = 0.0;
  int cells = 0;
  const auto look_at = [&](Cell c, bool passes_through) {
    const std::uint8_t value = known_cost(cost, c, unknown_as);
    costliest = std::max(costliest, value);
    if (!passes_through) return;
    weights += weight_of(value);
    ++cells;
  };
  Cell c = from;
  std::int64_t x = 0;
  std::int64_t y = 0;
  while (x < columns || y < rows) {
    const std::int64_t ahead = (1 + 2 * x) * rows - (1 + 2 * y) * columns;  // which border of the cell comes first
    if (ahead == 0) {
      look_at({c.x + step_x, c.y}, false);
      look_at({c.x, c.y + step_y}, false);
    }
    if (ahead <= 0) {
      c.x += step_x;
      ++x;
    }
    if (ahead >= 0) {
      c.y += step_y;
      ++y;
    }
    look_at(c, true);
  }
  const double length_cells = std::sqrt(static_cast<double>(columns * columns + rows * rows));
  return {costliest, cells > 0 ? length_cells * weights / cells : 0.0};
}

PathSmoother::PathSmoother(std::size_t max_cells) : max_cells_(max_cells) {
  corners_.reserve(max_cells);
  points_.reserve(4 * max_cells);
}

std::span<const Waypoint> PathSmoother::smooth(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path,
                                               const SmoothingOptions& options) {
  corners_.clear();
  points_.clear();
  if (path.empty()) return {};
  path = path.first(std::min(path.size(), max_cells_));
  pick_corners(cost, path, options);
  set_points(cost, path, options.spacing_m);
  return points_;
}

void PathSmoother::pick_corners(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path,
                                const SmoothingOptions& options) {
  corners_.push_back(0);
  for (std::size_t from = 0; from + 1 < path.size();) {
    std::size_t best = from + 1;
    std::uint8_t allowed = options.always_fine_cost;
    double along_path = 0.0;
    const std::size_t last = std::min(path.size() - 1, from + std::max<std::size_t>(options.max_span_cells, 1));
    for (std::size_t to = from + 1; to <= last && to <= best + kPatience_cells; ++to) {
      const std::uint8_t entered = known_cost(cost, path[to], options.unknown_as);
      const bool is_diagonal = path[to].x != path[to - 1].x && path[to].y != path[to - 1].y;
      along_path += weight_of(entered) * (is_diagonal ? std::sqrt(2.0) : 1.0);
      allowed = std::max(allowed, entered);
      if (to % (1 + (to - from) / kTrials) != 0 && to != last) continue;
      const LineCost line = cost_of_line(cost, path[from], path[to], options.unknown_as);
      if (line.costliest <= allowed && line.total <= along_path * kTolerance) best = to;
    }
    corners_.push_back(static_cast<std::uint32_t>(best));
    from = best;
  }
}

void PathSmoother::set_points(const CellGrid<std::uint8_t>& cost, std::span<const Cell> path, double spacing_m) {
  const auto centre = [&](std::uint32_t index) {
    return Waypoint{cost.centre_x_m(path[index]), cost.centre_y_m(path[index])};
  };
  const auto distance_m = [](Waypoint a, Waypoint b) { return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m); };
  double length_m = 0.0;
  for (std::size_t i = 1; i < corners_.size(); ++i)
    length_m += distance_m(centre(corners_[i - 1]), centre(corners_[i]));
  // However fine a spacing is asked for, the points fit into what is reserved.
  const double least_m = length_m / static_cast<double>(2 * max_cells_);
  points_.push_back(centre(0));
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    const Waypoint a = centre(corners_[i - 1]);
    const Waypoint b = centre(corners_[i]);
    const int pieces =
        spacing_m > 0.0
            ? std::max(1, static_cast<int>(std::ceil(distance_m(a, b) / std::max(spacing_m, least_m) - 1e-6)))
            : 1;
    for (int piece = 1; piece < pieces; ++piece) {
      const double t = static_cast<double>(piece) / pieces;
      points_.push_back({a.x_m + t * (b.x_m - a.x_m), a.y_m + t * (b.y_m - a.y_m)});
    }
    points_.push_back(b);
  }
}

}  // namespace g3d::nav
