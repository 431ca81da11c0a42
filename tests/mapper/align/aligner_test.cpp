// SPDX-License-Identifier: Apache-2.0
// Alignment where it helps and where it must not harm: a simulated robot whose odometry drifts, or lies.
#include "mapper/align/aligner.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/pose_drift.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world_file.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/voxel_map.hpp"
#include "tests/support/test_frames.hpp"
#include "tests/support/trajectory_error.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

constexpr double kPeriod_s = 0.1;

struct Drive {
  hal::CameraModel camera = test::small_camera(320);
  std::vector<hal::Frame> frames;
  std::vector<hal::StampedPose> truth;
};

/// Straight on from (x, y) at `speed_mps`, the camera 0.4 m above the floor.
Drive drive(const std::string& world_text, double x_m, double y_m, double yaw_deg, double speed_mps, int count) {
  Drive made;
  auto world = hal::parse_world(world_text, "test.world");
  REQUIRE(world.ok());
  hal::SimRenderer renderer(std::move(world).value(), {.camera = made.camera});
  const double yaw = yaw_deg * 3.14159265358979 / 180.0;
  for (int i = 0; i < count; ++i) {
    const double way_m = speed_mps * kPeriod_s * i;
    const hal::Pose pose =
        hal::camera_pose({x_m + way_m * std::cos(yaw), y_m + way_m * std::sin(yaw), 0.4}, yaw_deg, -5.0);
    const auto stamp_ns = static_cast<hal::TimeNs>(1e9 * kPeriod_s * i);
    made.frames.push_back(hal::make_frame(made.camera));
    renderer.render(pose, stamp_ns, static_cast<std::uint64_t>(i), made.frames.back());
    made.truth.push_back({stamp_ns, pose});
  }
  return made;
}

struct Run {
  std::vector<hal::StampedPose> poses;
  std::vector<AlignResult> results;
  AlignReport report;
};

Run align_all(const Drive& d, const std::vector<hal::StampedPose>& odometry, const AlignOptions& options = {},
              const SeenSpace* space = nullptr) {
  Aligner aligner(options, d.camera);
  Run run;
  for (std::size_t i = 0; i < d.frames.size(); ++i) {
    run.results.push_back(aligner.align(d.frames[i], odometry[i].T_world_camera, space));
    run.poses.push_back({d.frames[i].stamp_ns, run.results.back().T_world_camera});
  }
  run.report = aligner.report();
  return run;
}

const std::string kFurnished =
    "room 0 0 0 8 6 2.5 0.1\nbox 2 1.5 0 0.8 0.6 0.7\nbox 3 -1.5 0 0.5 1.2 1.1 20\ncylinder 1 -2 0 0.2 1.2\n"
    "box -1 2.4 0 1.5 0.5 1.8\nshelves 3.7 1.2 0 1.0 0.3 1.8 4 90\n";
/// Smooth walls, 2 m apart, out of sight at both ends.
const std::string kCorridor = "floor 0 0 0 60 4 0.1\nbox 0 1.05 0 60 0.1 2.5\nbox 0 -1.05 0 60 0.1 2.5\n";

}  // namespace

TEST_CASE("in a furnished room a drifting pose is held to a fraction of its error", "[mapper][align][slow]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 60);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto odometry = hal::drifted(d.truth, hal::robot_drift(seed));
    const Run run = align_all(d, odometry);
    const auto before = test::trajectory_error(d.truth, odometry);
    const auto after = test::trajectory_error(d.truth, run.poses);
    INFO("seed " << seed << ", odometry " << before.ate_m << " m, aligned " << after.ate_m << " m");
    CHECK(after.ate_m < 0.4 * before.ate_m);
    CHECK(after.ate_m < 0.010);
    CHECK(after.turn_rms_deg < 0.2);
    CHECK(run.report.corrected() >= 55);
  }
}

TEST_CASE("the same frames give the same poses, to the last bit", "[mapper][align]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 12);
  const auto odometry = hal::drifted(d.truth, hal::robot_drift(4));
  const Run a = align_all(d, odometry);
  const Run b = align_all(d, odometry);
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    CHECK(a.poses[i].T_world_camera.translation_m == b.poses[i].T_world_camera.translation_m);
    CHECK(a.poses[i].T_world_camera.rotation_xyzw == b.poses[i].T_world_camera.rotation_xyzw);
  }
}

TEST_CASE("along a smooth corridor the way is odometry's, and the report says so", "[mapper][align][slow]") {
  const Drive d = drive(kCorridor, -5, 0.1, 0, 0.4, 50);
  const double path_m = 0.4 * kPeriod_s * 49;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto odometry = hal::drifted(d.truth, hal::robot_drift(seed));
    const Run run = align_all(d, odometry);
    const double along_m = run.poses.back().T_world_camera.translation_m[0];
    const double odometry_m = odometry.back().T_world_camera.translation_m[0];
    INFO("seed " << seed);
    CHECK(std::abs(along_m - odometry_m) <= 0.01 * path_m + 0.002);
    CHECK(test::trajectory_error(d.truth, run.poses).ate_m <= test::trajectory_error(d.truth, odometry).ate_m + 0.001);
    CHECK(run.report.held_shift_frames > 40);
    CHECK(run.report.held_turn_frames == 0);
  }
}

TEST_CASE("in front of a wall that fills the view, nothing slides along it", "[mapper][align][slow]") {
  const Drive d = drive("box 3 0 -2 0.1 30 8\n", 0.0, 0.0, 0, 0.2, 40);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto odometry = hal::drifted(d.truth, hal::robot_drift(seed));
    const Run run = align_all(d, odometry);
    CHECK(test::trajectory_error(d.truth, run.poses).ate_m <= test::trajectory_error(d.truth, odometry).ate_m + 0.001);
    CHECK(run.report.held_shift_frames > 30);
  }
}

TEST_CASE("a covered camera, or one that sees nothing, leaves odometry as it is", "[mapper][align][slow]") {
  Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 40);
  for (std::size_t i = 10; i < 30; ++i) std::fill_n(d.frames[i].depth.get(), d.camera.pixel_count(), std::uint16_t{0});
  const auto odometry = hal::drifted(d.truth, hal::robot_drift(2));
  const Run run = align_all(d, odometry);
  CHECK(run.report.frames[static_cast<std::size_t>(AlignOutcome::few_samples)] == 20);
  for (std::size_t i = 10; i < 30; ++i) {
    const hal::Pose mine = hal::compose(hal::inverse(run.poses[i - 1].T_world_camera), run.poses[i].T_world_camera);
    const hal::Pose theirs = hal::compose(hal::inverse(odometry[i - 1].T_world_camera), odometry[i].T_world_camera);
    CHECK(shift_of(difference(theirs, mine)) < 1e-9);
  }
  CHECK(test::trajectory_error(d.truth, run.poses).ate_m < test::trajectory_error(d.truth, odometry).ate_m);
}

TEST_CASE("wheels that spin and a robot that is pushed: no worse than odometry", "[mapper][align][slow]") {
  const Drive standing = drive(kFurnished, -1.0, 0.2, 5, 0.0, 30);
  auto spinning = standing.truth;
  for (std::size_t i = 10; i < spinning.size(); ++i) {
    spinning[i].T_world_camera.translation_m[0] += 0.04 * static_cast<double>(std::min<std::size_t>(i - 9, 10));
  }
  CHECK(test::trajectory_error(standing.truth, align_all(standing, spinning).poses).ate_m <=
        test::trajectory_error(standing.truth, spinning).ate_m);

  const Drive pushed = drive(kFurnished, -1.0, 0.2, 5, 0.2, 30);
  auto still = pushed.truth;
  for (std::size_t i = 8; i < still.size(); ++i) still[i].T_world_camera = pushed.truth[7].T_world_camera;
  CHECK(test::trajectory_error(pushed.truth, align_all(pushed, still).poses).ate_m <=
        test::trajectory_error(pushed.truth, still).ate_m);
}

TEST_CASE("with a map, a frame that moves a robot too far leaves it exactly where its odometry has it",
          "[mapper][align][slow]") {
  const Drive pushed = drive(kFurnished, -1.0, 0.2, 5, 0.2, 30);
  auto still = pushed.truth;
  for (std::size_t i = 8; i < still.size(); ++i) still[i].T_world_camera = pushed.truth[7].T_world_camera;
  const mapper::VoxelMap map(mapper::Grid{0.05F}, {64, 64, 64});  // nobody has seen anything free
  const SeenSpace space(map);
  const Run run = align_all(pushed, still, {}, &space);
  for (std::size_t i = 8; i < still.size(); ++i) {
    CAPTURE(i);
    CHECK(run.results[i].outcome == AlignOutcome::implausible);
    CHECK(shift_of(difference(run.poses[7].T_world_camera, run.poses[i].T_world_camera)) < 1e-12);
  }
}

TEST_CASE("a pose beyond any building moves nothing, and the next one goes on as if it had not been",
          "[mapper][align]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 8);
  auto odometry = d.truth;
  odometry[4].T_world_camera.translation_m[1] = 1e300;
  const Run run = align_all(d, odometry);
  CHECK(run.results[4].outcome == AlignOutcome::implausible);
  CHECK(run.poses[4].T_world_camera.translation_m[1] == 1e300);
  const Vector6 off = difference(d.truth[7].T_world_camera, run.poses[7].T_world_camera);
  CHECK(shift_of(off) < 0.01);
}

TEST_CASE("a mount whose pitch is two degrees off does not spoil the plane", "[mapper][align][slow]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 40);
  auto believed = d.truth;
  const hal::Pose tilt = hal::from_xyz_rpy(0, 0, 0, 0.035, 0, 0);  // about the camera's x: pitch
  for (auto& pose : believed) pose.T_world_camera = hal::compose(pose.T_world_camera, tilt);
  const auto odometry = hal::drifted(believed, hal::robot_drift(3));
  const Run run = align_all(d, odometry);
  // The world as the tilted camera sees it is tilted once; the way in it must be as long and as straight.
  std::vector<hal::StampedPose> expected;
  const hal::Pose T_believed_true =
      hal::compose(believed.front().T_world_camera, hal::inverse(d.truth.front().T_world_camera));
  for (const auto& pose : d.truth)
    expected.push_back({pose.stamp_ns, hal::compose(T_believed_true, pose.T_world_camera)});
  CHECK(test::trajectory_error(expected, run.poses).ate_m < 0.02);
  CHECK(test::trajectory_error(expected, run.poses).ate_m < 0.6 * test::trajectory_error(d.truth, odometry).ate_m);
}

TEST_CASE("without odometry a hand-held camera is followed by what it sees", "[mapper][align][slow]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 40);
  auto still = d.truth;
  for (auto& pose : still) pose.T_world_camera = d.truth.front().T_world_camera;
  AlignOptions options;
  options.motion = Motion::free;
  options.source = OdometrySource::none;
  const Run run = align_all(d, still, options);
  CHECK(test::trajectory_error(d.truth, run.poses).ate_m < 0.05);
}

TEST_CASE("after a correction frames are aligned to where the surfaces are now", "[mapper][align]") {
  const Drive d = drive(kFurnished, -1.0, 0.2, 5, 0.3, 12);
  const hal::Pose T_moved = hal::from_xyz_rpy(0.4, -0.3, 0.0, 0.0, 0.0, 0.2);
  Aligner aligner({}, d.camera);
  Aligner twin({}, d.camera);  // that nobody corrects
  for (std::size_t i = 0; i < d.frames.size(); ++i) {
    const AlignResult result = aligner.align(d.frames[i], d.truth[i].T_world_camera);
    const AlignResult without = twin.align(d.frames[i], d.truth[i].T_world_camera);
    CHECK(result.outcome == without.outcome);
    CHECK(result.matched >= 0.85 * without.matched);
    const hal::Pose expected = i >= 8 ? hal::compose(T_moved, without.T_world_camera) : without.T_world_camera;
    const Vector6 off = difference(expected, result.T_world_camera);
    CHECK(shift_of(off) < 0.005);
    CHECK(turn_of(off) < 0.003);
    if (i == 7) aligner.correct(T_moved, [&](hal::TimeNs) { return T_moved; });
  }
  CHECK(aligner.report().corrected() >= 6);
}

TEST_CASE("a base whose turns are exact comes to be believed more than noisy images are", "[mapper][align][slow]") {
  auto world = hal::parse_world(kFurnished, "test.world");
  REQUIRE(world.ok());
  const hal::CameraModel camera = test::small_camera(160);
  hal::SimRenderer renderer(std::move(world).value(), {.camera = camera});
  hal::Frame frame = hal::make_frame(camera);
  AlignOptions fixed;
  fixed.learns_trust = false;
  Aligner learning({}, camera);
  Aligner believing(fixed, camera);
  double learning_rad2 = 0.0;
  double believing_rad2 = 0.0;
  for (int i = 0; i < 240; ++i) {  // a turn in place
    const hal::Pose truth = hal::camera_pose({0.0, 0.0, 0.4}, 1.5 * i, -5.0);
    renderer.render(truth, i * 100'000'000LL, static_cast<std::uint64_t>(i), frame);
    const auto square = [&](const AlignResult& result) {
      const double off = turn_of(difference(truth, result.T_world_camera));
      return off * off;
    };
    learning_rad2 += square(learning.align(frame, truth));
    believing_rad2 += square(believing.align(frame, truth));
  }
  CHECK(learning.trust().turn_scale() < 0.1);
  CHECK(learning_rad2 < believing_rad2);
}

TEST_CASE("in a hand nothing is learnt of turns, and they are held as loosely as they are stated to be",
          "[mapper][align]") {
  const Drive d = drive(kFurnished, -1.5, 0.0, 0.0, 0.2, 12);
  const std::vector<hal::StampedPose> odometry = hal::drifted(d.truth, hal::hand_held_drift(1));
  AlignOptions free;
  free.motion = Motion::free;
  AlignOptions fixed = free;
  fixed.learns_trust = false;
  const Run a = align_all(d, odometry, free);
  const Run b = align_all(d, odometry, fixed);
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    CHECK(a.poses[i].T_world_camera.translation_m == b.poses[i].T_world_camera.translation_m);
    CHECK(a.poses[i].T_world_camera.rotation_xyzw == b.poses[i].T_world_camera.rotation_xyzw);
  }
}
