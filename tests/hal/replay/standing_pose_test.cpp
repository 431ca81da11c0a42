// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/standing_pose.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("a camera that nobody tracked stands where it started, at any time", "[hal][replay]") {
  const StandingPose source(from_xyz_rpy(1, 2, 3, 0, 0, 0.5));
  for (const TimeNs stamp_ns : {TimeNs{-1}, TimeNs{0}, TimeNs{1} << 60}) {
    Pose pose;
    REQUIRE(source.pose_at(stamp_ns, pose) == PoseStatus::ok);
    CHECK(pose.translation_m == std::array{1.0, 2.0, 3.0});
  }
}
