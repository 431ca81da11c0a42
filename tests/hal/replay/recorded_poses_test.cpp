// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recorded_poses.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::TempFolder;
using g3d::test::write_plain;

namespace {

constexpr TimeNs kMs = 1'000'000;

StampedPose at(TimeNs stamp_ns, double x_m, double yaw_rad = 0) {
  return {stamp_ns, from_xyz_rpy(x_m, 0, 0, 0, 0, yaw_rad)};
}

}  // namespace

TEST_CASE("Poses are interpolated between their neighbours") {
  const RecordedPoses poses({at(1000 * kMs, 1), at(1100 * kMs, 2, 0.2), at(1200 * kMs, 4)});
  Pose pose;
  REQUIRE(poses.pose_at(1000 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == 1);
  REQUIRE(poses.pose_at(1025 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == Approx(1.25));
  CHECK(2 * std::atan2(pose.rotation_xyzw[2], pose.rotation_xyzw[3]) == Approx(0.05));
  REQUIRE(poses.pose_at(1150 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == Approx(3));
  REQUIRE(poses.pose_at(1200 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == 4);
}

TEST_CASE("Outside of the recording, and in its gaps, the pose is not known") {
  const RecordedPoses poses({at(1000 * kMs, 1), at(1500 * kMs, 2), at(2001 * kMs, 3)});
  Pose pose;
  CHECK(poses.pose_at(1000 * kMs - 1, pose) == PoseStatus::not_known);
  CHECK(poses.pose_at(1250 * kMs, pose) == PoseStatus::ok);  // half a second: just allowed
  CHECK(poses.pose_at(1600 * kMs, pose) == PoseStatus::not_known);
  CHECK(poses.pose_at(2001 * kMs, pose) == PoseStatus::ok);  // exactly recorded
  CHECK(poses.pose_at(2001 * kMs + 1, pose) == PoseStatus::not_known);
  CHECK(RecordedPoses({}).pose_at(0, pose) == PoseStatus::not_known);
}

TEST_CASE("Bad pose lines spoil their own time only") {
  StampedPose nan = at(1100 * kMs, 2);
  nan.T_world_camera.translation_m[1] = std::numeric_limits<double>::quiet_NaN();
  StampedPose unnormalised = at(1400 * kMs, 5);
  unnormalised.T_world_camera.rotation_xyzw = {0, 0, 0, 0};
  const RecordedPoses poses({at(1000 * kMs, 1), nan, at(1200 * kMs, 3), at(1300 * kMs, 4), unnormalised});
  Pose pose;
  CHECK(poses.pose_at(1000 * kMs, pose) == PoseStatus::ok);
  CHECK(poses.pose_at(1050 * kMs, pose) == PoseStatus::invalid);
  CHECK(poses.pose_at(1100 * kMs, pose) == PoseStatus::invalid);
  CHECK(poses.pose_at(1150 * kMs, pose) == PoseStatus::invalid);
  CHECK(poses.pose_at(1250 * kMs, pose) == PoseStatus::ok);
  CHECK(poses.pose_at(1400 * kMs, pose) == PoseStatus::invalid);
}

TEST_CASE("What is read is rescaled to a unit quaternion, and equal stamps do no harm") {
  RecordedPoses poses({{1, {{1, 0, 0}, {0, 0, 0, 0.995}}}, {1, {{2, 0, 0}, {0, 0, 0, 1}}}, {3, {{4, 0, 0}, {}}}});
  Pose pose;
  REQUIRE(poses.pose_at(1, pose) == PoseStatus::ok);
  CHECK(pose.rotation_xyzw[3] == 1.0);
  CHECK(pose.translation_m[0] == 1);
}

TEST_CASE("Poses come from the given file, else from the folder's trajectory") {
  const TempFolder folder;
  CHECK(RecordedPoses::open(folder.path()).error().reason == Reason::not_found);
  write_plain(folder / "groundtruth.txt", "1 7 0 0 0 0 0 1\n");
  write_plain(folder / "other.txt", "1 8 0 0 0 0 0 1\n");
  write_plain(folder / "unsorted.txt", "2 8 0 0 0 0 0 1\n1 8 0 0 0 0 0 1\n");
  Pose pose;
  const auto own = RecordedPoses::open(folder.path());
  REQUIRE(own.ok());
  CHECK(own.value()->count() == 1);
  CHECK(own.value()->pose_at(1000 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == 7);
  const auto given = RecordedPoses::open(folder.path(), folder / "other.txt");
  REQUIRE(given.ok());
  CHECK(given.value()->pose_at(1000 * kMs, pose) == PoseStatus::ok);
  CHECK(pose.translation_m[0] == 8);
  CHECK(RecordedPoses::open(folder.path(), folder / "unsorted.txt").error().text.find("unsorted.txt:2: ") !=
        std::string::npos);
  CHECK(RecordedPoses::open(folder.path(), folder / "none.txt").error().reason == Reason::not_found);
}
