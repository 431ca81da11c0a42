// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recorded_odometry.hpp"

#include <catch2/catch.hpp>

#include "hal/kobuki/packet_reader.hpp"
#include "hal/replay/recorded_poses.hpp"
#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal;
using Bytes = std::vector<std::uint8_t>;

struct Drive {
  Bytes file;
  kobuki::Odometry odometry;  // what the robot had
};

/// Half a metre ahead in an arc, two packets in each record, some noise between.
Drive recorded_drive() {
  Drive drive;
  kobuki::Feedback packet = g3d::tests::first_packet();
  Bytes line;
  for (int i = 0; i < 100; ++i) {
    packet.received_ns = (i | 1) * kobuki::kPacketPeriod_ns;
    drive.odometry.update(packet);
    const Bytes frame = g3d::tests::frame_of(packet);
    line.insert(line.end(), frame.begin(), frame.end());
    if (i % 10 == 4) line.push_back(0xAA);
    if (i % 2 == 1) {
      append_record(drive.file, packet.received_ns, line);
      line.clear();
    }
    packet = g3d::tests::packet_after(packet, 55, 65);
  }
  return drive;
}

TEST_CASE("a recording gives the robot's poses again, to the last bit") {
  const Drive drive = recorded_drive();
  const auto log = KobukiLog::parse(drive.file, "kobuki.bin");
  REQUIRE(log.ok());
  const RecordedOdometry again = recompute_odometry(log.value(), Pose{});
  CHECK(again.T_world_base == drive.odometry.T_world_base());
  CHECK(again.path_m == drive.odometry.path_m());
  CHECK(again.path_m == Approx(99 * 60 * kobuki::kMetresPerTick));
  // The first of two in one record was sent 20 ms before the second; only of the very first that cannot be known.
  REQUIRE(again.poses.size() == 99);
  for (std::size_t i = 1; i < 99; ++i) {
    CHECK(again.poses[i].stamp_ns - again.poses[i - 1].stamp_ns == Approx(kobuki::kPacketPeriod_ns).epsilon(0.01));
  }
  CHECK(again.poses.back().T_world_camera.translation_m[0] == drive.odometry.T_world_base().x_m);
  CHECK(again.counts.steps == 99);
  CHECK(again.rejects.skipped_bytes == 10);
  CHECK(again.rejects.total() == 0);
}

TEST_CASE("the camera rides on the base") {
  const Drive drive = recorded_drive();
  const auto log = KobukiLog::parse(drive.file, "kobuki.bin");
  REQUIRE(log.ok());
  Pose T_base_camera;
  T_base_camera.translation_m = {0.1, 0.0, 0.3};
  RecordedOdometry again = recompute_odometry(log.value(), T_base_camera, {2.0, 1.0, 3.14159265358979323846 / 2});
  const Pose first = again.poses.front().T_world_camera;
  CHECK(first.translation_m[0] == Approx(2.0).margin(1e-3));
  CHECK(first.translation_m[1] == Approx(1.1).margin(6e-3));
  CHECK(first.translation_m[2] == Approx(0.3));
  const RecordedPoses poses(std::move(again.poses));
  Pose between;
  CHECK(poses.pose_at(30 * kobuki::kPacketPeriod_ns, between) == PoseStatus::ok);
}

TEST_CASE("a log without packets gives no pose") {
  Bytes file;
  append_record(file, 1, Bytes(1000, 0x55));
  const auto log = KobukiLog::parse(file, "kobuki.bin");
  REQUIRE(log.ok());
  const RecordedOdometry nothing = recompute_odometry(log.value(), Pose{});
  CHECK(nothing.poses.empty());
  CHECK(nothing.T_world_base == PlanarPose{});
  CHECK(nothing.rejects.skipped_bytes == 1000);
}

}  // namespace
