// SPDX-License-Identifier: Apache-2.0
#include "net/pose_payload.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace g3d;

TEST_CASE("the pose of a submap is read exactly, and what is no pose is not", "[net]") {
  const hal::Pose pose = hal::from_xyz_rpy(1.0 / 3.0, -7.77, 0.1, 0.02, -0.01, 2.2);
  const net::PosePayload payload = net::pose_payload(pose, 0.02F);
  const auto read = net::read_pose_payload(payload);
  REQUIRE(read);
  CHECK(read->T_world_submap.translation_m == pose.translation_m);
  CHECK(read->T_world_submap.rotation_xyzw == pose.rotation_xyzw);
  CHECK(read->resolution_m == 0.02F);

  CHECK_FALSE(net::read_pose_payload(mapper::ByteSpan(payload).first(59)));
  for (const float size :
       {0.0F, -0.05F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    CHECK_FALSE(net::read_pose_payload(net::pose_payload(pose, size)));
  hal::Pose bad = pose;
  bad.translation_m[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(net::read_pose_payload(net::pose_payload(bad, 0.02F)));
  bad = pose;
  bad.rotation_xyzw = {0, 0, 0, 0};
  CHECK_FALSE(net::read_pose_payload(net::pose_payload(bad, 0.02F)));
}
