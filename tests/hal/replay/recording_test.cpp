// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recording.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d::hal;

namespace {

const std::string kHash(64, '7');

}  // namespace

TEST_CASE("a recording's own file is read line by line") {
  const auto log = parse_mapped_log(
      "# a comment\nfootprint 1 -2.5 0 0.18 0.6\nmasked 12.5 masked/12.500000000.g3i\n"
      "colour no\ncannot be made again: 3 frames\nmap " +
          kHash + "\n",
      "m");
  REQUIRE(log.ok());
  CHECK(log.value().footprint->at_m == std::array{1.0, -2.5, 0.0});
  CHECK(log.value().footprint->radius_m == 0.18);
  CHECK(log.value().footprint->height_m == 0.6);
  CHECK(log.value().masked.at(12'500'000'000) == "masked/12.500000000.g3i");
  CHECK_FALSE(log.value().with_colour);
  CHECK(log.value().cannot == std::vector<std::string>{"be made again: 3 frames"});
  CHECK(log.value().hash == kHash);
}

TEST_CASE("a recording that ended in the middle of a line is read up to there") {
  const auto log = parse_mapped_log("colour no\nfootprint 1 2 0 0.1", "m");
  REQUIRE(log.ok());
  CHECK_FALSE(log.value().footprint.has_value());
  CHECK_FALSE(log.value().with_colour);
  CHECK(log.value().hash.empty());
  CHECK(parse_mapped_log("", "m").ok());
}

TEST_CASE("a line that says nothing of a recording is named") {
  for (const std::string line :
       {"footprint 1 2 3 4", "footprint 1 2 3 0 1", "footprint 1 2 3 1 1 1", "footprint nan 2 3 1 1",
        "masked 1 ../../etc/passwd", "masked x a", "masked 1", "colour maybe", "cannot", "map 12", "poses"}) {
    INFO(line);
    const auto log = parse_mapped_log("colour yes\n" + line + "\n", "m.txt");
    REQUIRE_FALSE(log.ok());
    CHECK(log.error().text.find("m.txt:2: ") == 0);
  }
}

TEST_CASE("exact poses are those that were given, and there are none in between") {
  Pose odd;
  odd.rotation_xyzw = {0.0, 0.0, 0.6, 0.7999};  // not quite of unit length, and not to be made so
  const ExactPoses poses({{10, {}}, {20, odd}});
  Pose pose;
  CHECK(poses.pose_at(20, pose) == PoseStatus::ok);
  CHECK(pose.rotation_xyzw == odd.rotation_xyzw);
  CHECK(poses.pose_at(10, pose) == PoseStatus::ok);
  for (const TimeNs stamp_ns : {9, 11, 15, 19, 21}) CHECK(poses.pose_at(stamp_ns, pose) == PoseStatus::not_known);
  Pose no_pose;
  no_pose.rotation_xyzw = {0.0, 0.0, 0.0, 0.0};
  CHECK(ExactPoses({{5, no_pose}}).pose_at(5, pose) == PoseStatus::invalid);
}
