// SPDX-License-Identifier: Apache-2.0
// Two robots' maps of one place whose poses are off, and maps of different places that must not be joined.
//   map_align_bench [--trials N] [--strangers N] [--resolution METRES] [--log FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <string>

#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/seeded_random.hpp"
#include "mapper/align/map_aligner.hpp"
#include "mapper/align/pose_step.hpp"
#include "tests/support/look_around.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

/// Halves of one way; the second map's frame is `shift_m` and `turn_deg` off, in a direction of chance.
void halves(const test::Workload& work, float resolution_m, double shift_m, double turn_deg, int trials,
            bool anywhere) {
  const std::size_t half = work.frames.size() / 2;
  const auto a = test::map_in_own_frame(work, 0, half, resolution_m, {});
  const MapSurfaces surfaces_a(a->map());
  std::vector<double> error_mm, error_deg, search_ms, surfaces_ms;
  std::vector<double> overlaps;
  std::map<std::string, int> outcomes;
  hal::SeededRandom random(11);
  for (int trial = 0; trial < trials; ++trial) {
    const double way = 2.0 * std::numbers::pi * random.uniform();
    const double turn = (random.uniform() < 0.5 ? -1.0 : 1.0) * turn_deg * kDegree;
    // The second robot starts in the middle of the way, and has its map's origin there.
    const auto& start = work.frames[half].T_world_camera.translation_m;
    const hal::Pose to_start{{start[0], start[1], 0.0}, {0, 0, 0, 1}};
    const hal::Pose wrong = hal::from_xyz_rpy(shift_m * std::cos(way), shift_m * std::sin(way), 0, 0, 0, turn);
    const hal::Pose T_b_world = hal::inverse(to_start);
    const hal::Pose guess = hal::compose(to_start, wrong);
    const auto b = test::map_in_own_frame(work, half, half, resolution_m, T_b_world);
    const auto begin = std::chrono::steady_clock::now();
    const MapSurfaces surfaces_b(b->map());
    const auto middle = std::chrono::steady_clock::now();
    const MapAlignment found = align_maps(surfaces_a, surfaces_b, guess, {.anywhere = anywhere});
    const auto end = std::chrono::steady_clock::now();
    surfaces_ms.push_back(std::chrono::duration<double, std::milli>(middle - begin).count());
    search_ms.push_back(std::chrono::duration<double, std::milli>(end - middle).count());
    ++outcomes[to_string(found.outcome)];
    if (found.outcome != MapAlignOutcome::aligned) {
      fmt::print("    {} overlap {:.2f} runner-up {:.2f} area {:.1f}\n", to_string(found.outcome), found.overlap,
                 found.runner_up, found.area_m2);
      continue;
    }
    // At the second start, where it matters.
    const Vector6 error = difference(to_start, found.T_a_b);
    overlaps.push_back(found.overlap);
    error_mm.push_back(1e3 * shift_of(error));
    error_deg.push_back(turn_of(error) / kDegree);
  }
  fmt::print(
      "{} r={:.2f} m, off by {:.1f} m and {:.0f} degrees{}: error {:.1f} / {:.1f} mm, {:.2f} / {:.2f} degrees (median "
      "/ max)"
      ", surfaces {:.0f} ms, search {:.0f} ms (median), {:.0f} ms at most; overlap {:.2f} at least;",
      work.name, resolution_m, shift_m, turn_deg, anywhere ? ", unknown" : "", quantile(error_mm, 0.5),
      quantile(error_mm, 1.0), quantile(error_deg, 0.5), quantile(error_deg, 1.0), quantile(surfaces_ms, 0.5),
      quantile(search_ms, 0.5), quantile(search_ms, 1.0), quantile(overlaps, 0.0));
  for (const auto& [name, count] : outcomes) fmt::print(" {} {}", count, name);
  fmt::print("\n");
  std::fflush(stdout);
}

/// Maps of rooms of different buildings, as if their poses were roughly the same.
void strangers(int trials, float resolution_m) {
  struct Place {
    std::string name;
    std::unique_ptr<mapper::Mapper> mapper;
    std::unique_ptr<MapSurfaces> surfaces;
  };
  std::vector<Place> places;
  for (const std::string_view world : hal::exploration_names()) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const test::Workload work = test::look_around(std::string(world), seed);
      if (work.frames.empty()) continue;
      const auto& at = work.frames.front().T_world_camera.translation_m;
      Place place{std::string(world), nullptr, nullptr};
      place.mapper =
          test::map_in_own_frame(work, 0, work.frames.size(), resolution_m, {{-at[0], -at[1], 0}, {0, 0, 0, 1}});
      place.surfaces = std::make_unique<MapSurfaces>(place.mapper->map());
      places.push_back(std::move(place));
    }
  }
  hal::SeededRandom random(5);
  std::map<std::string, int> outcomes;
  std::vector<double> overlaps;
  for (int trial = 0; trial < trials;) {
    const Place& a = places[static_cast<std::size_t>(random.uniform() * static_cast<double>(places.size()))];
    const Place& b = places[static_cast<std::size_t>(random.uniform() * static_cast<double>(places.size()))];
    if (a.name == b.name) continue;
    ++trial;
    const hal::Pose guess = hal::from_xyz_rpy(0, 0, 0, 0, 0, 2.0 * std::numbers::pi * random.uniform());
    const MapAlignment found = align_maps(*a.surfaces, *b.surfaces, guess);
    ++outcomes[to_string(found.outcome)];
    overlaps.push_back(found.overlap);
    if (found.outcome == MapAlignOutcome::aligned) {
      fmt::print("  joined: {} and {}, overlap {:.2f}, runner-up {:.2f}, {:.1f} m2, residual {:.1f} mm\n", a.name,
                 b.name, found.overlap, found.runner_up, found.area_m2, 1e3 * found.residual_m);
    }
  }
  fmt::print("{} pairs of maps of different places ({} maps): overlap {:.2f} / {:.2f} / {:.2f} (median / p99 / max);",
             trials, places.size(), quantile(overlaps, 0.5), quantile(overlaps, 0.99), quantile(overlaps, 1.0));
  for (const auto& [name, count] : outcomes) fmt::print(" {} {}", count, name);
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  int trials = 10;
  int pairs = 100;
  float resolution_m = 0.05F;
  std::string log;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--trials") trials = std::atoi(argv[i + 1]);
    if (word == "--strangers") pairs = std::atoi(argv[i + 1]);
    if (word == "--resolution") resolution_m = static_cast<float>(std::atof(argv[i + 1]));
    if (word == "--log") log = argv[i + 1];
  }
  const test::Workload work =
      log.empty() ? test::simulated_drive("furnished_room", 120, 0.5, 0.0, 320) : test::recorded(log, 150);
  if (work.frames.empty()) {
    fmt::print(stderr, "map_align_bench: no frames\n");
    return 1;
  }
  halves(work, resolution_m, 0.3, 10.0, trials, false);
  halves(work, resolution_m, 1.0, 30.0, trials, false);
  halves(work, resolution_m, 3.0, 120.0, std::min(trials, 4), true);
  if (pairs > 0) strangers(pairs, resolution_m);
  return 0;
}
