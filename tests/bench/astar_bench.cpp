// SPDX-License-Identifier: Apache-2.0
// Time of one plan, and of one distance field, on grids of 1000 x 1000 cells: offices inflated as the robot inflates
// them, an empty hall, costs of any value anywhere, a maze, and the real floor plans that are there. Starts and goals
// are drawn from the cells where the robot can stand; every plan's cost is compared with the distance field's, and
// every way with it.
//   astar_bench [--plans N] [--wall-time]
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "nav/astar.hpp"
#include "nav/distance_field.hpp"
#include "nav/inflation.hpp"
#include "nav/path_smoothing.hpp"
#include "tests/support/floor_plans.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using nav::Cell;
using nav::CellGrid;
using nav::CellState;
using Costs = CellGrid<std::uint8_t>;

namespace {

constexpr int kSide_cells = 1000;

// The thread's own time: on a machine that others use it alone says what the work costs.
clockid_t used_clock = CLOCK_THREAD_CPUTIME_ID;

double now_ms() {
  timespec t{};
  clock_gettime(used_clock, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double quantile(std::vector<double>& values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(fraction * static_cast<double>(values.size())))];
}

Costs inflated(const CellGrid<CellState>& floor) {
  nav::Inflation inflation(floor, {});
  inflation.rebuild(floor);
  return inflation.cost();
}

// Walls with one gap each, at alternating ends: the longest way there is.
CellGrid<CellState> maze() {
  CellGrid<CellState> floor(0.05, 0, 0, kSide_cells, kSide_cells, CellState::free);
  for (int wall = 1; wall * 25 < kSide_cells; ++wall) {
    for (int x = 0; x < kSide_cells - 25; ++x) {
      floor.at({wall % 2 == 0 ? x : kSide_cells - 1 - x, wall * 25}) = CellState::occupied;
    }
  }
  return floor;
}

struct Times {
  std::vector<double> plan_ms, smooth_ms, field_ms;
  std::uint64_t expansions = 0;
  std::uint64_t wrong = 0;
};

void run(const std::string& name, const Costs& cost, int plans, Times& all) {
  nav::AStar planner(cost.cells.size());
  nav::DistanceField field(cost.cells.size());
  nav::PathSmoother smoother;
  std::vector<Cell> places;
  for (std::size_t i = 0; i < cost.cells.size(); ++i) {
    if (cost.cells[i] < nav::kInscribedCost) places.push_back(cost.cell(i));
  }
  tests::Random random(1);
  const auto any = [&] { return places[random.below(static_cast<std::uint32_t>(places.size()))]; };
  Times times;
  std::size_t reached = 0;
  for (int i = 0; i < plans; ++i) {
    const Cell start = any();
    const Cell goal = any();
    const double t0 = now_ms();
    const nav::PathResult path = planner.plan(cost, start, {&goal, 1});
    const double t1 = now_ms();
    times.plan_ms.push_back(t1 - t0);
    times.expansions += path.expansions;
    (void)smoother.smooth(cost, path.cells);
    times.smooth_ms.push_back(now_ms() - t1);
    const double t2 = now_ms();
    field.compute(cost, start);
    times.field_ms.push_back(now_ms() - t2);
    reached += field.reached().size();
    const bool same = path.status == nav::PathStatus::found ? path.cost == field.cost_to(goal)
                                                            : field.cost_to(goal) == nav::DistanceField::kUnreached;
    times.wrong += same ? 0 : 1;
  }
  const double total_ms = [&] {
    double sum = 0;
    for (const double t : times.plan_ms) sum += t;
    return sum;
  }();
  all.plan_ms.insert(all.plan_ms.end(), times.plan_ms.begin(), times.plan_ms.end());
  all.wrong += times.wrong;
  fmt::print(
      "{:24} {:4}x{:<4} plan p50 {:6.2f}  p99 {:6.2f}  max {:6.2f} ms, {:4.0f} k cells, {:3.0f} ns each; smooth p99 "
      "{:5.2f} ms; field p99 {:6.2f} ms for {:4.0f} k cells; {} wrong\n",
      name, cost.columns, cost.rows, quantile(times.plan_ms, 0.5), quantile(times.plan_ms, 0.99),
      quantile(times.plan_ms, 1.0), static_cast<double>(times.expansions) / plans * 1e-3,
      total_ms * 1e6 / static_cast<double>(std::max<std::uint64_t>(times.expansions, 1)),
      quantile(times.smooth_ms, 0.99), quantile(times.field_ms, 0.99), static_cast<double>(reached) / plans * 1e-3,
      times.wrong);
}

}  // namespace

int main(int argc, char** argv) {
  int plans = 200;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--wall-time") == 0) used_clock = CLOCK_MONOTONIC;
    if (std::strcmp(argv[i], "--plans") == 0 && i + 1 < argc) plans = std::max(1, std::atoi(argv[++i]));
  }
  Times all;
  for (const std::uint64_t seed : {1, 2, 3}) {
    run(fmt::format("office {}", seed), inflated(tests::office_floor(seed, kSide_cells)), plans, all);
  }
  run("maze", inflated(maze()), plans, all);
  run("empty hall", Costs(0.05, 0, 0, kSide_cells, kSide_cells, nav::kFreeCost), plans, all);
  run("costs of any value", tests::random_costs(7, kSide_cells, kSide_cells), plans, all);
  for (const std::string& plan : tests::real_floor_plans()) {
    const auto floor = tests::mapped_floor(plan);
    if (floor) run(std::filesystem::path(plan).stem().string(), inflated(*floor), plans, all);
  }
  fmt::print("all plans: p50 {:.2f} ms, p99 {:.2f} ms, max {:.2f} ms; {} wrong\n", quantile(all.plan_ms, 0.5),
             quantile(all.plan_ms, 0.99), quantile(all.plan_ms, 1.0), all.wrong);
  return all.wrong == 0 ? 0 : 1;
}
