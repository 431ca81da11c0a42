// SPDX-License-Identifier: Apache-2.0
// One robot of ours in a simulated building, as `g3dmap sim --robots 1 --camera 160x120@10` drives it, but for who
// chooses its goals.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "hal/result.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/world.hpp"
#include "nav/navigator.hpp"

namespace g3d::tests {

struct BuildingRun {
  std::optional<double> t90_s;
  std::optional<double> t95_s;
  std::optional<double> t99_s;
  double end_s = 0.0;
  double coverage = 0.0;
  double path_m = 0.0;
  double rotation_rad = 0.0;
  std::uint32_t goals_failed = 0;
  bool is_home = false;
};

/// A world with the robot's start in it.
struct Building {
  hal::World world;
  hal::PlanarPose start;
  hal::Observable observable;
};
[[nodiscard]] hal::Result<Building> load_building(const std::string& name_or_file, std::uint64_t seed);

struct BuildingRunOptions {
  std::uint64_t seed = 1;
  double limit_s = 3600.0;
  double enough = 0.99;  ///< ends when so much is covered; above 1: when it is home
  std::function<void(nav::NavigatorConfig&)> change;
  std::function<void(double time_s, double coverage, const nav::Navigator&)> every_second;
};
/// The configuration that `change` is given.
[[nodiscard]] nav::NavigatorConfig usual_navigator(const hal::PlanarPose& start);
[[nodiscard]] BuildingRun run_in_building(const Building& building, const BuildingRunOptions& options);

}  // namespace g3d::tests
