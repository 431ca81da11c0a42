// SPDX-License-Identifier: Apache-2.0
// Exploration on floor plans, ours against two yardsticks in the same simulator and limits: explore_lite, and a tour
// planned with full knowledge. Prints a line per run and a table per plan.
//
//   explore_bench [--worlds a,b] [--seeds N] [--first-seed N] [--maps FILE.yaml,...] [--cache FILE] [--trace] [--lines]
//   [--enough SHARE]
//                 [--part K/N] [--yardsticks]
//
// The yardsticks' results are kept in the cache file, so that a changed explorer is measured without them.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/explore_lite.hpp"
#include "tests/support/flat_explore.hpp"
#include "tests/support/offline_tour.hpp"

namespace {

using namespace g3d;
using namespace g3d::tests;

constexpr double kLimit_s = 20000.0;  ///< ours ends by itself long before

struct Yardsticks {
  FlatResult lite;
  FlatResult tour;
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    out.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return out;
}

std::map<std::string, Yardsticks> read_cache(const std::string& path) {
  std::map<std::string, Yardsticks> out;
  std::FILE* file = path.empty() ? nullptr : std::fopen(path.c_str(), "r");
  if (file == nullptr) return out;
  char key[200];
  Yardsticks y;
  while (std::fscanf(file, "%199s %lf %lf %lf %lf %lf %lf %lf %lf", key, &y.lite.t90_s, &y.lite.t95_s, &y.lite.t99_s,
                     &y.lite.coverage, &y.tour.t90_s, &y.tour.t95_s, &y.tour.t99_s, &y.tour.coverage) == 9) {
    out[key] = y;
  }
  std::fclose(file);
  return out;
}

void add_to_cache(const std::string& path, const std::string& key, const Yardsticks& y) {
  std::FILE* file = path.empty() ? nullptr : std::fopen(path.c_str(), "a");
  if (file == nullptr) return;
  fmt::print(file, "{} {} {} {} {} {} {} {} {}\n", key, y.lite.t90_s, y.lite.t95_s, y.lite.t99_s, y.lite.coverage,
             y.tour.t90_s, y.tour.t95_s, y.tour.t99_s, y.tour.coverage);
  std::fclose(file);
}

struct Sums {
  int runs = 0;
  int reached_99 = 0;
  int reached_95 = 0;
  int premature = 0;
  int home = 0;
  int contacts = 0;
  int lite_95 = 0;
  int lite_99 = 0;
  double t95 = 0, t99 = 0, tour_95 = 0, tour_99 = 0, ratio_95 = 0, ratio_99 = 0, worst_95 = 0, worst_99 = 0;
  double lite_ratio = 0, coverage = 0, turn = 0, path = 0;
  int lite_compared = 0;
  int tour_95_compared = 0;  ///< runs where the tour got there too: means and ratios are of these
  int tour_99_compared = 0;

  void add(const FlatResult& r, const Yardsticks& y) {
    ++runs;
    reached_99 += r.t99_s >= 0;
    reached_95 += r.t95_s >= 0;
    premature += r.ended && r.t99_s < 0;
    home += r.home;
    contacts += r.contacts;
    lite_95 += y.lite.t95_s >= 0;
    lite_99 += y.lite.t99_s >= 0;
    coverage += r.coverage;
    turn += r.turned_rad;
    path += r.path_m;
    if (r.t95_s >= 0 && y.tour.t95_s > 0) {
      ++tour_95_compared;
      t95 += r.t95_s;
      tour_95 += y.tour.t95_s;
      worst_95 = std::max(worst_95, r.t95_s / y.tour.t95_s);
    }
    if (r.t99_s >= 0 && y.tour.t99_s > 0) {
      ++tour_99_compared;
      t99 += r.t99_s;
      tour_99 += y.tour.t99_s;
      worst_99 = std::max(worst_99, r.t99_s / y.tour.t99_s);
    }
    if (r.t95_s >= 0 && y.lite.t95_s > 0) {
      ++lite_compared;
      lite_ratio += r.t95_s / y.lite.t95_s;
    }
  }
  void print(const std::string& name) const {
    fmt::print(
        "{:20s} {:4d} {:4d} {:4d} {:5d} {:5d} {:5d} | {:7.1f} {:7.1f} | {:5.2f} {:5.2f} | {:5.2f} {:5.2f} | {:4d} "
        "{:4d} {:5.2f} | {:6.2f} {:6.1f} {:6.1f}\n",
        name, runs, reached_95, reached_99, premature, home, contacts, t95 / std::max(tour_95_compared, 1),
        t99 / std::max(tour_99_compared, 1), t95 / tour_95, worst_95, t99 / tour_99, worst_99, lite_95, lite_99,
        lite_ratio / std::max(lite_compared, 1), 100 * coverage / runs, path / runs, turn / runs);
  }
};

void print_head() {
  fmt::print(
      "{:20s} {:>4} {:>4} {:>4} {:>5} {:>5} {:>5} | {:>7} {:>7} | {:>11} | {:>11} | {:>4} {:>4} {:>5} | {:>6} {:>6} "
      "{:>6}\n",
      "plan", "runs", "95%", "99%", "early", "home", "touch", "T95 s", "T99 s", "/tour95 max", "/tour99 max", "l95",
      "l99", "/lite", "cover%", "path", "turn");
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> names(flat_world_names().begin(), flat_world_names().end());
  std::vector<std::string> maps;
  std::string cache_path;
  std::uint64_t seeds = 5;
  std::uint64_t first_seed = 1;
  bool trace = false;
  bool lines = false;
  double enough = 2.0;
  bool yardsticks_only = false;
  int part = 0;
  int parts = 1;
  nav::ExplorerConfig config;
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* option) { return std::strcmp(argv[i], option) == 0; };
    const auto value = [&]() -> std::string { return i + 1 < argc ? argv[++i] : ""; };
    if (is("--worlds")) {
      names = split(value());
    } else if (is("--maps")) {
      maps = split(value());
    } else if (is("--seeds")) {
      seeds = std::stoull(value());
    } else if (is("--first-seed")) {
      first_seed = std::stoull(value());
    } else if (is("--cache")) {
      cache_path = value();
    } else if (is("--trace")) {
      trace = true;
    } else if (is("--enough")) {
      enough = std::stod(value());
    } else if (is("--lines")) {
      lines = true;
    } else if (is("--yardsticks")) {
      yardsticks_only = true;
    } else if (is("--part")) {
      const std::string v = value();
      part = v.empty() ? 0 : v[0] - '0';
      parts = v.size() < 3 ? 1 : v[2] - '0';
    } else {
      fmt::print(stderr, "unknown option {}\n", argv[i]);
      return 2;
    }
  }
  if (names.size() == 1 && names[0] == "none") names.clear();
  names.insert(names.end(), maps.begin(), maps.end());
  std::map<std::string, Yardsticks> cache = read_cache(cache_path);
  print_head();
  Sums all;
  double cpu_s = 0;
  int number = 0;
  for (const std::string& name : names) {
    Sums sums;
    for (std::uint64_t seed = first_seed; seed < first_seed + seeds; ++seed) {
      if (number++ % parts != part) continue;
      const bool is_map = name.find(".yaml") != std::string::npos;
      const FlatWorld world = is_map ? read_flat_world(name, 26.0) : make_flat_world(name, seed);
      const hal::PlanarPose start = choose_start(world, seed);
      const auto room = standing_room(world.solid);
      const auto reachable = connected_part(room, room.cell_of(start.x_m, start.y_m));
      const auto observable = observable_cells(world.solid, reachable, 0.8, 3.5);
      const auto make_sim = [&] {
        auto sim = std::make_unique<FlatSim>(world, start);
        sim->set_observable(&observable);
        return sim;
      };
      const std::string key = fmt::format("{}/{}", world.name, seed);
      if (!cache.contains(key)) {
        Yardsticks y;
        y.tour = run_offline_tour(*make_sim(), world, reachable, observable);
        y.lite = run_explore_lite(*make_sim(), 10 * y.tour.end_s);
        cache[key] = y;
        add_to_cache(cache_path, key, y);
      }
      const Yardsticks& y = cache[key];
      if (yardsticks_only) continue;
      const auto begin = std::chrono::steady_clock::now();
      auto sim = make_sim();
      const FlatResult r = run_explorer(*sim, kLimit_s, config, trace, enough);
      const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      cpu_s += took_s;
      sums.add(r, y);
      all.add(r, y);
      if (lines) {
        fmt::print(
            "{:24s} ours {:6.1f} {:6.1f} {:6.1f} end {:6.1f} {:6.2f} % home {} touch {} | tour {:6.1f} {:6.1f} {:6.1f} "
            "{:6.2f} % | lite {:6.1f} {:6.1f} {:6.1f} {:6.2f} % | {:.2f} {:.2f} | path {:.1f} turn {:.1f} goals {} cpu "
            "{:.2f} |{}\n",
            key, r.t90_s, r.t95_s, r.t99_s, r.end_s, 100 * r.coverage, r.home, r.contacts, y.tour.t90_s, y.tour.t95_s,
            y.tour.t99_s, 100 * y.tour.coverage, y.lite.t90_s, y.lite.t95_s, y.lite.t99_s, 100 * y.lite.coverage,
            r.t95_s / y.tour.t95_s, r.t99_s / y.tour.t99_s, r.path_m, r.turned_rad, r.goals, took_s, r.left);
        std::fflush(stdout);
      }
    }
    if (sums.runs > 0) sums.print(name.substr(name.rfind('/') + 1));
    std::fflush(stdout);
  }
  if (all.runs > 0) all.print("all");
  fmt::print("cpu {:.1f} s\n", cpu_s);
  return 0;
}
