// SPDX-License-Identifier: Apache-2.0
// `g3dmap drift`: the poses of a recording as odometry would have had them.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "hal/replay/trajectory_file.hpp"
#include "hal/replay/tum_folder.hpp"
#include "hal/sim/pose_drift.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"

namespace g3d {
int run_drift(const DriftOptions& options) {
  std::string path = options.poses;
  if (std::filesystem::is_directory(path)) {
    auto found = hal::find_trajectory(path);
    if (!found) return fail(found.error().text);
    path = std::move(found).value();
  }
  auto poses = hal::read_trajectory(path);
  if (!poses) return fail(poses.error().text);
  const std::size_t before = poses.value().size();
  std::erase_if(poses.value(), [](const hal::StampedPose& pose) { return !hal::is_valid(pose.T_world_camera); });
  if (poses.value().empty()) return fail(fmt::format("{}: no valid pose in it; give another file", path));
  const bool hand_held = options.motion == "free";
  const auto drifted =
      hal::drifted(poses.value(), hand_held ? hal::hand_held_drift(options.seed) : hal::robot_drift(options.seed));
  if (const auto written = hal::write_trajectory(options.out, drifted); !written) return fail(written.error().text);
  fmt::print("{}  {} poses of {}, drifting as {}, seed {}{}\n", options.out, drifted.size(), path,
             hand_held ? "a hand-held camera" : "a robot on wheels", options.seed,
             before == drifted.size() ? "" : fmt::format("; {} that are none were left out", before - drifted.size()));
  return kExitDone;
}

}  // namespace g3d
