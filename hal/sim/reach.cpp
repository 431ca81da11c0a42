// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "hal/sim/seeded_random.hpp"

namespace g3d::hal {
namespace {

constexpr double kSpare_m = 0.10;
constexpr double kApart_m = 0.60;
constexpr int kTries = 24;       // for the widest part of a floor
constexpr int kDraws = 200'000;  // before a floor counts as too full
constexpr double kNoStep_m = -0.03;

int cell_of(double at_m, double cell_m) { return static_cast<int>(std::floor(at_m / cell_m)); }

bool has_floor(const FloorContact& floor, double x_m, double y_m, double radius_m) {
  for (int i = 0; i < 8; ++i) {
    constexpr double kDiagonal = 0.7071067811865476;
    constexpr double kX[] = {1, kDiagonal, 0, -kDiagonal, -1, -kDiagonal, 0, kDiagonal};
    const double dx = radius_m * kX[i];
    const double dy = radius_m * kX[(i + 6) % 8];
    if (floor.floor_m(x_m + dx, y_m + dy) < kNoStep_m) return false;
  }
  return floor.floor_m(x_m, y_m) >= kNoStep_m;
}

struct Span {
  double low = 1e9;
  double high = -1e9;
  void add(double from, double to) {
    low = std::min(low, from);
    high = std::max(high, to);
  }
};

/// Fills from one cell; returns how many are new.
std::size_t fill_from(const FloorContact& floor, const PlanFrame& frame, int column, int row,
                      const ReachOptions& options, std::vector<std::uint8_t>& reached) {
  if (!frame.contains(column, row) || reached[frame.index(column, row)] != 0) return 0;
  if (!fits(floor, frame.x_m(column), frame.y_m(row), options)) return 0;
  std::vector<std::pair<int, int>> open = {{column, row}};
  reached[frame.index(column, row)] = 1;
  std::size_t count = 0;
  while (!open.empty()) {
    const auto [c, r] = open.back();
    open.pop_back();
    ++count;
    constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& step : kSteps) {
      const int nc = c + step[0];
      const int nr = r + step[1];
      if (!frame.contains(nc, nr) || reached[frame.index(nc, nr)] != 0) continue;
      if (!fits(floor, frame.x_m(nc), frame.y_m(nr), options)) continue;
      reached[frame.index(nc, nr)] = 1;
      open.emplace_back(nc, nr);
    }
  }
  return count;
}

}  // namespace

int PlanFrame::column_of(double x_m) const { return cell_of(x_m, cell_m) - first_x; }
int PlanFrame::row_of(double y_m) const { return cell_of(y_m, cell_m) - first_y; }

Result<PlanFrame> plan_frame(const World& world, double cell_m) {
  Span x;
  Span y;
  for (const Primitive& p : world.primitives()) {
    if (p.mover >= 0) continue;
    const PlanExtent half = plan_extent(p);
    x.add(double{p.centre_m[0]} - half.x_m, double{p.centre_m[0]} + half.x_m);
    y.add(double{p.centre_m[1]} - half.y_m, double{p.centre_m[1]} + half.y_m);
  }
  if (world.grid()) {
    const GridWalls& grid = *world.grid();
    const auto [low_x, low_y] = grid.origin_m();
    x.add(double{low_x}, double{low_x} + grid.width_cells() * double{grid.cell_m()});
    y.add(double{low_y}, double{low_y} + grid.height_cells() * double{grid.cell_m()});
  }
  if (x.low > x.high)
    return Error{Reason::bad_usage, "the world has nothing that stands still, so it has no floor plan"};
  PlanFrame frame;
  frame.cell_m = cell_m;
  frame.first_x = cell_of(x.low, cell_m);
  frame.first_y = cell_of(y.low, cell_m);
  frame.columns = cell_of(x.high, cell_m) - frame.first_x + 1;
  frame.rows = cell_of(y.high, cell_m) - frame.first_y + 1;
  if (frame.count() > kMaxPlanCells) {
    return Error{Reason::too_large,
                 fmt::format("a floor plan of {} x {} cells is too large; crop the world", frame.columns, frame.rows)};
  }
  return frame;
}

bool fits(const FloorContact& floor, double x_m, double y_m, const ReachOptions& options) {
  bool is_free = true;
  floor.for_near(x_m, y_m, options.radius_m, options.body, {}, -1,
                 [&](const FloorContact::Thing&) { is_free = false; });
  return is_free && has_floor(floor, x_m, y_m, options.radius_m);
}

std::vector<std::uint8_t> reachable_cells(const FloorContact& floor, const PlanFrame& frame,
                                          std::span<const PlanarPose> starts, const ReachOptions& options) {
  std::vector<std::uint8_t> reached(frame.count(), 0);
  for (const PlanarPose& start : starts) {
    (void)fill_from(floor, frame, frame.column_of(start.x_m), frame.row_of(start.y_m), options, reached);
  }
  return reached;
}

Result<std::vector<PlanarPose>> choose_starts(const World& world, std::size_t count, std::uint64_t seed,
                                              const ReachOptions& options) {
  const auto& named = world.starts();
  const FloorContact floor(world);
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (fits(floor, named[i].x_m, named[i].y_m, options)) continue;
    return Error{Reason::bad_usage,
                 fmt::format("a robot of {:.2f} m does not fit at start {} of the world, ({:.2f}, {:.2f}); "
                             "move it away from what stands there",
                             2.0 * options.radius_m, i + 1, named[i].x_m, named[i].y_m)};
  }
  if (seed == 1 && named.size() >= count) {
    return std::vector<PlanarPose>(named.begin(), named.begin() + static_cast<std::ptrdiff_t>(count));
  }
  const auto frame = plan_frame(world);
  if (!frame) return frame.error();
  const PlanFrame& plan = frame.value();
  SeededRandom random(seed);
  const auto draw = [&] {
    // One after the other: compilers do not agree on the order of a call's arguments.
    const auto row = static_cast<int>(random.bits() % static_cast<std::uint64_t>(plan.rows));
    const auto column = static_cast<int>(random.bits() % static_cast<std::uint64_t>(plan.columns));
    return std::pair(column, row);
  };
  std::vector<std::uint8_t> reached;
  if (!named.empty()) {
    reached = reachable_cells(floor, plan, {named.data(), 1}, options);
  } else {
    std::size_t widest = 0;
    std::vector<std::uint8_t> all(plan.count(), 0);
    for (int found = 0, i = 0; found < kTries && i < kDraws; ++i) {
      const auto [column, row] = draw();
      if (!fits(floor, plan.x_m(column), plan.y_m(row), options)) continue;
      ++found;
      const std::vector<std::uint8_t> before = all;
      const std::size_t cells = fill_from(floor, plan, column, row, options, all);
      if (cells <= widest) continue;
      widest = cells;
      reached.assign(plan.count(), 0);
      for (std::size_t n = 0; n < reached.size(); ++n) reached[n] = all[n] != before[n] ? 1 : 0;
    }
  }
  ReachOptions wider = options;
  wider.radius_m += kSpare_m;
  std::vector<PlanarPose> starts;
  for (int i = 0; i < kDraws && starts.size() < count && !reached.empty(); ++i) {
    const auto [column, row] = draw();
    const double heading_rad = (random.uniform() - 0.5) * 2.0 * std::numbers::pi;
    const PlanarPose pose{plan.x_m(column), plan.y_m(row), heading_rad};
    if (reached[plan.index(column, row)] == 0 || !fits(floor, pose.x_m, pose.y_m, wider)) continue;
    if (std::any_of(starts.begin(), starts.end(), [&](const PlanarPose& other) {
          return std::hypot(other.x_m - pose.x_m, other.y_m - pose.y_m) < kApart_m;
        })) {
      continue;
    }
    starts.push_back(pose);
  }
  if (starts.size() < count) {
    return Error{Reason::no_capacity, fmt::format("there is room for {} of {} robots of {:.2f} m; give starts",
                                                  starts.size(), count, 2.0 * options.radius_m)};
  }
  return starts;
}

}  // namespace g3d::hal
