// SPDX-License-Identifier: Apache-2.0
// Exploration in simulated buildings, ours against two yardsticks on the very same robot: explore_lite's choice of
// goals, and a tour planned with full knowledge. Prints a line per run, and the ratios at the end.
//
//   yardstick_bench [--worlds "A B FILE.yaml ..."] [--seeds N] [--first-seed N] [--only ours|tour|lite] [--limit S]
//                   [--cache FILE] [--again ours] [--trace]
//
// A run ends when 99 % are seen, when the robot is home again, or after `--limit` simulated seconds. Finished runs are
// kept in the cache file and not made again; `--again WHO` makes those of one anew.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/building_run.hpp"
#include "tests/support/lite_chooser.hpp"
#include "tests/support/tour_chooser.hpp"

namespace {

using namespace g3d;
using namespace g3d::tests;

constexpr std::array<const char*, 3> kWho{"tour", "ours", "lite"};

struct Options {
  std::vector<std::string> worlds{"office", "loops", "house", "warehouse", "maze", "hall", "lab", "doorways", "glass"};
  std::uint64_t seeds = 2;
  std::uint64_t first_seed = 1;
  std::string only;
  std::string again;
  std::string cache = "build/yardstick_bench.txt";
  double limit_s = 1200.0;
  bool trace = false;
};

struct Result {
  double t95_s = -1.0;  ///< -1: never
  double t99_s = -1.0;
  double coverage = 0.0;
  double end_s = 0.0;
  double path_m = 0.0;
  double rotation_rad = 0.0;
};
using Results = std::map<std::string, Result>;  ///< by "WORLD/SEED/WHO"

Results read_cache(const Options& options) {
  Results results;
  std::ifstream file(options.cache);
  std::string key;
  Result r;
  while (file >> key >> r.t95_s >> r.t99_s >> r.coverage >> r.end_s >> r.path_m >> r.rotation_rad) {
    if (options.again.empty() || !key.ends_with("/" + options.again)) results[key] = r;
  }
  return results;
}

Result run(const Building& building, const BuildingPlan* plan, const std::string& who, std::uint64_t seed,
           const Options& options) {
  BuildingRunOptions o;
  o.seed = seed;
  o.limit_s = options.limit_s;
  if (who == "lite") o.change = drive_like_explore_lite;
  if (who == "tour") o.change = [plan](nav::NavigatorConfig& config) { drive_tour(config, *plan); };
  if (options.trace) {
    o.every_second = [](double time_s, double coverage, const nav::Navigator& n) {
      const hal::PlanarPose& goal = n.decision().goal;
      fmt::print(
          "  {:6.0f} s {:6.2f} % kind {} goal {:6.2f} {:6.2f} {:5.2f} for {:5.0f}, path {:5.1f} turned {:6.1f} {}\n",
          time_s, 100.0 * coverage, static_cast<int>(n.decision().kind), goal.x_m, goal.y_m, goal.heading_rad,
          n.decision().expected_cells, n.report().path_m, n.report().rotation_rad,
          static_cast<int>(n.follower().state()));
    };
  }
  const BuildingRun r = run_in_building(building, o);
  return {r.t95_s.value_or(-1.0), r.t99_s.value_or(-1.0), r.coverage, r.end_s, r.path_m, r.rotation_rad};
}

void print_ratio(const std::string& name, std::vector<double> ratios, std::size_t runs) {
  if (ratios.empty()) return fmt::print("{}: never both\n", name);
  std::sort(ratios.begin(), ratios.end());
  double sum = 0.0;
  for (const double r : ratios) sum += r;
  fmt::print("{}: min {:.2f}, median {:.2f}, mean {:.2f}, max {:.2f}; {} of {} runs where both got there\n", name,
             ratios.front(), ratios[ratios.size() / 2], sum / static_cast<double>(ratios.size()), ratios.back(),
             ratios.size(), runs);
}

void print_sums(const Results& results, const std::vector<std::string>& runs) {
  for (const char* who : kWho) {
    int made = 0, to_95 = 0, to_99 = 0;
    for (const std::string& run : runs) {
      const auto r = results.find(run + "/" + who);
      if (r == results.end()) continue;
      ++made;
      to_95 += r->second.t95_s >= 0.0;
      to_99 += r->second.t99_s >= 0.0;
    }
    fmt::print("{}: {} runs, {} to 95 %, {} to 99 %\n", who, made, to_95, to_99);
  }
  for (const char* other : {"tour", "lite"}) {
    std::vector<double> at_95, at_99;
    for (const std::string& run : runs) {
      const auto ours = results.find(run + "/ours");
      const auto theirs = results.find(run + "/" + other);
      if (ours == results.end() || theirs == results.end()) continue;
      if (ours->second.t95_s > 0 && theirs->second.t95_s > 0) {
        at_95.push_back(ours->second.t95_s / theirs->second.t95_s);
      }
      if (ours->second.t99_s > 0 && theirs->second.t99_s > 0) {
        at_99.push_back(ours->second.t99_s / theirs->second.t99_s);
      }
    }
    print_ratio(fmt::format("T95 ours / {}", other), at_95, runs.size());
    print_ratio(fmt::format("T99 ours / {}", other), at_99, runs.size());
  }
}

bool read_options(int argc, char** argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--trace") {
      options.trace = true;
      continue;
    }
    if (i + 1 >= argc) return false;
    const std::string value = argv[++i];
    if (name == "--worlds") {
      std::istringstream words(value);
      options.worlds.clear();
      for (std::string word; words >> word;) options.worlds.push_back(word);
    } else if (name == "--seeds") {
      options.seeds = std::stoull(value);
    } else if (name == "--first-seed") {
      options.first_seed = std::stoull(value);
    } else if (name == "--only") {
      options.only = value;
    } else if (name == "--again") {
      options.again = value;
    } else if (name == "--cache") {
      options.cache = value;
    } else if (name == "--limit") {
      options.limit_s = std::stod(value);
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (!read_options(argc, argv, options)) {
    fmt::print(stderr, "yardstick_bench: see the head of tests/bench/yardstick_bench.cpp for its options\n");
    return 2;
  }
  Results results = read_cache(options);
  std::vector<std::string> runs;
  for (std::uint64_t seed = options.first_seed; seed < options.first_seed + options.seeds; ++seed) {
    for (const std::string& world : options.worlds) {
      const std::string name = fmt::format("{}/{}", world.substr(world.rfind('/') + 1), seed);
      runs.push_back(name);
      std::optional<Building> building;
      std::optional<BuildingPlan> plan;
      for (const std::string who : kWho) {
        const std::string key = name + "/" + who;
        if (!options.only.empty() && who != options.only) continue;
        if (!results.contains(key)) {
          if (!building) {
            auto loaded = load_building(world, seed);
            if (!loaded) {
              fmt::print(stderr, "{}: {}\n", world, loaded.error().text);
              return 1;
            }
            building = std::move(loaded).value();
          }
          if (who == "tour" && !plan) {
            plan = survey(building->world, building->observable, usual_navigator(building->start));
          }
          const Result r = results[key] = run(*building, plan ? &*plan : nullptr, who, seed, options);
          std::ofstream(options.cache, std::ios::app) << fmt::format("{} {} {} {} {} {} {}\n", key, r.t95_s, r.t99_s,
                                                                     r.coverage, r.end_s, r.path_m, r.rotation_rad);
        }
        const Result& r = results[key];
        fmt::print("{:28s} {} T95 {:7.1f} T99 {:7.1f} s, {:6.2f} % after {:7.1f} s, {:6.1f} m, {:6.1f} rad\n", name,
                   who, r.t95_s, r.t99_s, 100.0 * r.coverage, r.end_s, r.path_m, r.rotation_rad);
        std::fflush(stdout);
      }
    }
  }
  print_sums(results, runs);
  return 0;
}
