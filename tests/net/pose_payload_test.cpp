// SPDX-License-Identifier: Apache-2.0
#include "net/pose_payload.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace g3d;

TEST_CASE("the pose of a submap is read exactly, and what is no pose is not", "[net]") {
  const hal::Pose pose = hal::from_xyz_rpy(1.0 / 3.0, -7.77, 0.1, 0.02, -0.01, 2.2);
  net::PosePayload payload = net::pose_payload(pose);
  hal::Pose read;
  REQUIRE(net::read_pose_payload(payload, read));
  CHECK(read.translation_m == pose.translation_m);
  CHECK(read.rotation_xyzw == pose.rotation_xyzw);

  const hal::Pose before = read;
  CHECK_FALSE(net::read_pose_payload(mapper::ByteSpan(payload).first(55), read));
  hal::Pose bad = pose;
  bad.translation_m[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(net::read_pose_payload(net::pose_payload(bad), read));
  bad = pose;
  bad.rotation_xyzw = {0, 0, 0, 0};
  CHECK_FALSE(net::read_pose_payload(net::pose_payload(bad), read));
  CHECK(read.translation_m == before.translation_m);
}
