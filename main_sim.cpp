// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim` with a camera path: a simulated Kinect flies through a world.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/replay/recorded_poses.hpp"
#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/pose_drift.hpp"
#include "hal/sim/sim_camera.hpp"
#include "main_commands.hpp"
#include "main_run.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"

namespace g3d {
namespace {

/// What odometry says at the time of each frame; nothing if it is exact.
std::vector<hal::StampedPose> drifting_poses(const hal::CameraPath& path, double rate_hz, const SimOptions& options) {
  if (options.drift <= 0.0) return {};
  std::vector<hal::StampedPose> poses;
  for (std::size_t i = 0;; ++i) {
    const hal::TimeNs stamp_ns = hal::frame_stamp_ns(path, i, rate_hz);
    if (stamp_ns > path.end_ns()) break;
    poses.push_back({stamp_ns, path.pose_at(stamp_ns)});
  }
  return hal::drifted(poses, options.mapping.motion == "free"
                                 ? hal::hand_held_drift(options.mapping.seed, options.drift)
                                 : hal::robot_drift(options.mapping.seed, options.drift));
}

}  // namespace

int run_sim(const SimOptions& options, const std::string& command_line) {
  if (!options.camera.empty() || !options.area.empty()) {
    return bad_usage("--camera and --area are of robots: add --robots 1");
  }
  const StagingOptions& staging = options.staging;
  if (!staging.control.empty() || !staging.at.empty() || !staging.fail.empty() || staging.battery_min > 0.0) {
    return bad_usage("--control, --at, --fail and --battery are of robots: add --robots 1");
  }
  if (!options.cuts.empty() || !options.deaths.empty()) {
    return bad_usage("--partition and --kill are of teams: add --robots 2 or more");
  }
  const auto loaded_board = effective_board(options.mapping);
  if (!loaded_board) return fail(loaded_board.error().text);
  const board::Board& board = loaded_board.value();
  const std::string world_name = options.world == "builtin" ? "furnished_room" : options.world;
  const auto crop = choose_rectangle("--crop", options.crop);
  if (!crop) return bad_usage(crop.error().text);
  auto world = hal::load_world(world_name, crop.value());
  if (!world)
    return world.error().reason == hal::Reason::bad_usage ? bad_usage(world.error().text) : fail(world.error().text);
  if (options.camera_path == "builtin" && hal::builtin_path(world_name).empty()) {
    fmt::print(stderr, "g3dmap: --world {} is a file, so its drive must be given: --camera-path FILE\n", options.world);
    return kExitBadUsage;
  }
  const std::string path_name = options.camera_path == "builtin" ? world_name : options.camera_path;
  auto path = hal::load_camera_path(path_name);
  if (!path) return fail(path.error().text);
  path = path.value().laps(options.laps);

  hal::SimCameraOptions camera_options;
  camera_options.renderer.noise = !options.no_noise;
  camera_options.renderer.seed = options.mapping.seed;
  camera_options.renderer.threads = board.map_threads;
  camera_options.renderer.camera = camera_model(board);
  camera_options.rate_hz = options.frame_rate_hz.value_or(board.camera_rate_hz);
  if (options.duration_s > 0.0) {
    camera_options.max_frames = static_cast<std::size_t>(std::max(1.0, options.duration_s * camera_options.rate_hz));
  }
  const hal::SimPoses poses(path.value());
  const hal::RecordedPoses odometry(drifting_poses(path.value(), camera_options.rate_hz, options));
  hal::SimCamera camera(std::move(world).value(), std::move(path).value(), camera_options);
  return map_source({camera, options.drift > 0.0 ? static_cast<const hal::PoseSource&>(odometry) : poses, {}}, board,
                    options.mapping, command_line);
}

}  // namespace g3d
