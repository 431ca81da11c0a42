// SPDX-License-Identifier: Apache-2.0
// A robot's way through a building with odometry that drifts: as odometry has it, aligned frame by frame, and with
// loops. Distance from the true way, and how much of the map is where the true poses have it.
//   loop_bench --world NAME [--way trajectory.tum] [--drift X] [--seed N] [--seeds N] [--every SECONDS] [--fixed-trust]
//              [--verbose]
// trajectory.tum: where the camera was, such as `g3dmap sim --world NAME --robots 1 --camera 160x120@10` writes it.
// Without it, the drive that is built in for that world, twice.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>

#include "hal/frame_pool.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/pose_drift.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/mapper.hpp"
#include "mapper/submaps/looped_map.hpp"
#include "tests/support/map_sharpness.hpp"
#include "tests/support/trajectory_error.hpp"

using namespace g3d;

namespace {

struct Options {
  std::string world = "office";
  std::string way;
  std::uint64_t seed = 1;
  std::uint64_t seeds = 1;
  double every_s = 0.2;
  double drift = 1.0;
  bool has_fixed_trust = false;
  bool verbose = false;
};

Options read_options(int argc, char** argv) {
  Options o;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&] { return i + 1 < argc ? std::string(argv[++i]) : std::string(); };
    if (word == "--world") o.world = value();
    if (word == "--way") o.way = value();
    if (word == "--seed") o.seed = std::strtoull(value().c_str(), nullptr, 10);
    if (word == "--seeds") o.seeds = std::strtoull(value().c_str(), nullptr, 10);
    if (word == "--every") o.every_s = std::atof(value().c_str());
    if (word == "--drift") o.drift = std::atof(value().c_str());
    if (word == "--fixed-trust") o.has_fixed_trust = true;
    if (word == "--verbose") o.verbose = true;
  }
  return o;
}

using Poses = std::vector<hal::StampedPose>;

constexpr hal::CameraModel kCamera{160, 120, 131.25F, 131.25F, 79.875F, 59.875F, 1000.0F};

mapper::MapperConfig config() {
  mapper::MapperConfig c;
  c.with_colour = false;
  c.capacity = mapper::capacity_for_bytes(std::size_t{512} << 20);
  return c;
}

struct Maps {
  mapper::Mapper truth{config(), kCamera};
  mapper::Mapper drifting{config(), kCamera};
  mapper::Mapper aligned{config(), kCamera};
  mapper::Mapper looped{config(), kCamera};
};

void print_map(const char* name, const Poses& truth, const Poses& poses, const mapper::VoxelMap& map,
               const mapper::VoxelMap& true_map) {
  const test::TrajectoryError e = test::trajectory_error(truth, poses);
  fmt::print("  {:10} ATE {:7.1f} mm, turn rms {:5.2f} degrees; map precision {:6.2f} %, recall {:6.2f} %\n", name,
             1e3 * e.ate_m, e.turn_rms_deg, 100.0 * test::share_near(map, true_map),
             100.0 * test::share_near(true_map, map));
}

hal::Result<Poses> true_way(const Options& o) {
  if (!o.way.empty()) return hal::read_trajectory(o.way);
  const auto path = hal::load_camera_path(o.world);
  if (!path) return path.error();
  const hal::CameraPath twice = path.value().laps(2);
  const auto step_ns = static_cast<hal::TimeNs>(1e9 * o.every_s);
  Poses poses;
  for (hal::TimeNs t = twice.begin_ns(); t <= twice.end_ns(); t += step_ns) poses.push_back({t, twice.pose_at(t)});
  return poses;
}

int run(const Options& o, std::uint64_t seed) {
  auto world = hal::load_world(o.world);
  auto way = true_way(o);
  if (!world || !way) {
    fmt::print(stderr, "loop_bench: {}\n", !world ? world.error().text : way.error().text);
    return 1;
  }
  Poses truth;
  for (const hal::StampedPose& pose : way.value()) {
    if (truth.empty() || pose.stamp_ns - truth.back().stamp_ns >= static_cast<hal::TimeNs>(0.99e9 * o.every_s)) {
      truth.push_back(pose);
    }
  }
  const Poses odometry = hal::drifted(truth, hal::robot_drift(seed, o.drift));
  hal::SimRendererOptions options;
  options.camera = kCamera;
  options.threads = 1;
  hal::SimRenderer renderer(std::move(world).value(), options);
  auto maps = std::make_unique<Maps>();
  mapper::submaps::LoopedOptions looped_options;
  looped_options.align.learns_trust = !o.has_fixed_trust;
  mapper::submaps::LoopedMap looped(maps->looped.map(), kCamera, looped_options);
  mapper::align::Aligner aligner(looped_options.align, kCamera);
  Poses aligned;
  Poses placed;
  hal::Frame frame = hal::make_frame(kCamera);
  double longest_ms = 0.0;
  double all_ms = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    renderer.render(truth[i].T_world_camera, truth[i].stamp_ns, i, frame);
    (void)maps->truth.integrate(frame, truth[i].T_world_camera);
    (void)maps->drifting.integrate(frame, odometry[i].T_world_camera);
    aligned.push_back({truth[i].stamp_ns, aligner.align(frame, odometry[i].T_world_camera).T_world_camera});
    (void)maps->aligned.integrate(frame, aligned.back().T_world_camera);
    placed.push_back({truth[i].stamp_ns, looped.align(frame, odometry[i].T_world_camera).T_world_camera});
    (void)maps->looped.integrate(frame, placed.back().T_world_camera);
    const auto start = std::chrono::steady_clock::now();
    const bool moved = looped.add(frame, maps->looped.changed_slots());
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    longest_ms = std::max(longest_ms, ms);
    all_ms += ms;
    if (moved && o.verbose) {
      const auto r = looped.report();
      const hal::Pose now = looped.corrected(placed.back().stamp_ns, placed.back().T_world_camera);
      fmt::print("  {:7.1f} s: {} submaps, {} loops, off by {:.0f} mm before, {:.0f} mm after\n",
                 static_cast<double>(frame.stamp_ns) / 1e9, r.submaps, r.loops,
                 1e3 * mapper::align::shift_of(
                           mapper::align::difference(truth[i].T_world_camera, placed.back().T_world_camera)),
                 1e3 * mapper::align::shift_of(mapper::align::difference(truth[i].T_world_camera, now)));
    }
  }
  looped.finish();
  for (hal::StampedPose& pose : placed) pose.T_world_camera = looped.corrected(pose.stamp_ns, pose.T_world_camera);
  fmt::print("{} seed {}: {} frames, {:.0f} s\n", o.world, seed, truth.size(),
             static_cast<double>(truth.back().stamp_ns - truth.front().stamp_ns) / 1e9);
  print_map("odometry", truth, odometry, maps->drifting.map(), maps->truth.map());
  print_map("aligned", truth, aligned, maps->aligned.map(), maps->truth.map());
  print_map("loops", truth, placed, maps->looped.map(), maps->truth.map());
  const auto r = looped.report();
  double worst_m = 0.0;
  double worst_rad = 0.0;
  for (const auto& edge : looped.edges()) {
    if (!edge.is_loop) continue;
    const auto true_anchor = [&](std::uint32_t i) {
      const hal::TimeNs at_ns = looped.chain().submaps()[i].anchor_ns;
      const auto p = std::lower_bound(truth.begin(), truth.end(), at_ns,
                                      [](const hal::StampedPose& pose, hal::TimeNs t) { return pose.stamp_ns < t; });
      return p->T_world_camera;
    };
    const hal::Pose right = hal::compose(hal::inverse(true_anchor(edge.from)), true_anchor(edge.to));
    const auto off = mapper::align::difference(right, edge.T_from_to);
    worst_m = std::max(worst_m, mapper::align::shift_of(off));
    worst_rad = std::max(worst_rad, mapper::align::turn_of(off));
  }
  fmt::print(
      "  {} submaps, {} loops ({} alone, {} disbelieved), the worst off by {:.0f} mm and {:.1f} mrad; tried {}, "
      "refused {}, not found again {}; {} corrections of up to {:.2f} m; {:.1f} MB; {:.0f} ms at most, {:.2f} "
      "per frame\n",
      r.submaps, r.loops, r.alone, r.disbelieved, 1e3 * worst_m, 1e3 * worst_rad, r.finder.tried, r.finder.refused,
      r.finder.not_again, r.corrections, r.largest_move_m, static_cast<double>(looped.chain().memory_bytes()) / 1e6,
      longest_ms, all_ms / static_cast<double>(truth.size()));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Options o = read_options(argc, argv);
  int result = 0;
  for (std::uint64_t seed = o.seed; seed < o.seed + o.seeds; ++seed) result |= run(o, seed);
  return result;
}
