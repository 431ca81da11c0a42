// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/odometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/kobuki/packet_reader.hpp"
#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal;
using namespace g3d::hal::kobuki;
using g3d::tests::first_packet;
using g3d::tests::packet_after;

constexpr double kPi = 3.14159265358979323846;

/// Drives on and keeps our clock in step with the base's.
struct Drive {
  Odometry odometry;
  Feedback last = first_packet();

  Drive() { odometry.update(last); }
  void step(int left_ticks, int right_ticks) {
    const TimeNs received_ns = last.received_ns + kPacketPeriod_ns;
    last = packet_after(last, left_ticks, right_ticks);
    last.received_ns = received_ns;
    odometry.update(last);
  }
};

TEST_CASE("three captured packets move the base as published") {
  PacketReader reader;
  Odometry odometry;
  for (const auto hex : {g3d::tests::kPacketK1, g3d::tests::kPacketK2}) {
    reader.feed(g3d::tests::from_hex(hex), 0, [&](const Feedback& f) { odometry.update(f); });
  }
  CHECK(odometry.T_world_base().x_m == Approx(0.6397e-3).epsilon(1e-3));
  CHECK(odometry.T_world_base().heading_rad == Approx(0.01 * kPi / 180));
  CHECK(odometry.velocity().forward_mps == Approx(0.6397e-3 / 0.02).epsilon(1e-3));
  reader.feed(g3d::tests::from_hex(g3d::tests::kPacketK3), 0, [&](const Feedback& f) { odometry.update(f); });
  CHECK(odometry.T_world_base().x_m == Approx(2 * 0.6397e-3).epsilon(1e-3));
  CHECK(odometry.counts().steps == 2);
}

TEST_CASE("the first packet is the reference and moves nothing") {
  Odometry odometry({1.0, 2.0, 0.5});
  odometry.update(first_packet());
  CHECK(odometry.T_world_base() == PlanarPose{1.0, 2.0, 0.5});
  CHECK(odometry.velocity() == Twist{});
}

TEST_CASE("straight on, over encoder and stamp wraps and back") {
  Drive drive;
  for (int i = 0; i < 5000; ++i) drive.step(100, 100);
  CHECK(drive.odometry.T_world_base().x_m == Approx(500'000 * kMetresPerTick));
  CHECK(drive.odometry.T_world_base().y_m == Approx(0.0).margin(1e-9));
  CHECK(drive.odometry.velocity().forward_mps == Approx(100 * kMetresPerTick / 0.02));
  for (int i = 0; i < 5000; ++i) drive.step(-100, -100);
  CHECK(drive.odometry.T_world_base().x_m == Approx(0.0).margin(1e-9));
  CHECK(drive.odometry.path_m() == Approx(1'000'000 * kMetresPerTick));
}

TEST_CASE("a circle ends where it began") {
  Drive drive;
  const double radius_m = kWheelBase_m / 2 * (80.0 + 120.0) / (120.0 - 80.0);
  double farthest_m = 0.0;
  double turned_rad = 0.0;
  while (turned_rad < 2 * kPi) {
    const double before_rad = drive.odometry.rotation_rad();
    drive.step(80, 120);
    turned_rad += drive.odometry.rotation_rad() - before_rad;
    farthest_m = std::max(farthest_m, drive.odometry.T_world_base().y_m);
  }
  CHECK(farthest_m == Approx(2 * radius_m).epsilon(0.01));  // the gyro's 0.01 deg, 85 in each step
  CHECK(std::hypot(drive.odometry.T_world_base().x_m, drive.odometry.T_world_base().y_m) < 0.02);
}

TEST_CASE("turning on the spot wraps the heading and moves nothing") {
  Drive drive;
  for (int i = 0; i < 1000; ++i) {
    drive.step(-90, 90);
    const double heading_rad = drive.odometry.T_world_base().heading_rad;
    REQUIRE((heading_rad > -kPi && heading_rad <= kPi));
  }
  CHECK(drive.odometry.T_world_base().x_m == Approx(0.0).margin(1e-12));
  CHECK(drive.odometry.velocity().turn_radps == Approx(180 * kMetresPerTick / kWheelBase_m / 0.02).epsilon(0.01));
  CHECK(drive.odometry.rotation_rad() == Approx(1000 * 180 * kMetresPerTick / kWheelBase_m).epsilon(0.01));
}

TEST_CASE("a repeated stamp moves nothing, and soon the base stands") {
  Drive drive;
  drive.step(100, 100);
  const PlanarPose before = drive.odometry.T_world_base();
  for (int i = 0; i < 10; ++i) {
    drive.last.received_ns += kPacketPeriod_ns;
    Feedback repeated = drive.last;
    repeated.left_encoder_ticks = static_cast<std::uint16_t>(repeated.left_encoder_ticks + 50);
    drive.odometry.update(repeated);
    CHECK(drive.odometry.T_world_base() == before);
    CHECK((drive.odometry.velocity() == Twist{}) == (i >= 5));
  }
  CHECK(drive.odometry.counts().duplicates == 10);
}

TEST_CASE("a gap in which the base went on is one arc") {
  Drive drive;
  for (int i = 0; i < 10; ++i) drive.step(100, 100);
  for (int gap_packets : {5, 20, 130}) {
    const double before_m = drive.odometry.T_world_base().x_m;
    const std::uint64_t restarts = drive.odometry.counts().restarts;
    for (int i = 1; i < gap_packets; ++i) {
      const TimeNs received_ns = drive.last.received_ns + kPacketPeriod_ns;
      drive.last = packet_after(drive.last, 100, 100);
      drive.last.received_ns = received_ns;
    }
    drive.step(100, 100);
    CAPTURE(gap_packets);
    CHECK(drive.odometry.T_world_base().x_m == Approx(before_m + 100 * gap_packets * kMetresPerTick));
    CHECK(drive.odometry.counts().restarts == restarts);
  }
  CHECK(drive.odometry.counts().gaps == 2);
}

TEST_CASE("a way that may have wrapped in a long gap is not believed, a short one is") {
  for (const int ticks : {0, 10, -10, 30}) {
    Drive drive;
    for (int i = 1; i < 1000; ++i) {
      const TimeNs received_ns = drive.last.received_ns + kPacketPeriod_ns;
      drive.last = packet_after(drive.last, ticks, ticks);
      drive.last.received_ns = received_ns;
    }
    drive.step(ticks, ticks);
    CAPTURE(ticks);
    const bool is_believed = std::abs(ticks) < 30;
    CHECK(drive.odometry.T_world_base().x_m == Approx(is_believed ? 1000 * ticks * kMetresPerTick : 0.0));
    CHECK(drive.odometry.counts().out_of_gates == (is_believed ? 0 : 1));
  }
}

TEST_CASE("a restarted base keeps its pose") {
  Drive drive;
  for (int i = 0; i < 10; ++i) drive.step(100, 110);
  const PlanarPose before = drive.odometry.T_world_base();
  drive.last.timestamp_ms = 0;
  drive.last.left_encoder_ticks = drive.last.right_encoder_ticks = 0;
  drive.last.gyro_angle_cdeg = 0;
  drive.last.received_ns += 8'000'000'000;
  drive.odometry.update(drive.last);
  CHECK(drive.odometry.T_world_base() == before);
  CHECK(drive.odometry.velocity() == Twist{});
  CHECK(drive.odometry.counts().restarts == 1);
  drive.step(100, 100);
  CHECK(std::hypot(drive.odometry.T_world_base().x_m - before.x_m, drive.odometry.T_world_base().y_m - before.y_m) ==
        Approx(100 * kMetresPerTick));
}

TEST_CASE("further than a base can get is not believed") {
  Drive drive;
  drive.step(10, 10);
  const PlanarPose before = drive.odometry.T_world_base();
  drive.step(5000, 5000);
  CHECK(drive.odometry.T_world_base() == before);
  CHECK(drive.odometry.counts().out_of_gates == 1);
}

TEST_CASE("at rest the gyro's drift does not turn the base, a push does") {
  Drive drive;
  for (int i = 0; i < 50; ++i) drive.step(0, 0);
  for (int i = 0; i < 500; ++i) {
    drive.last.gyro_angle_cdeg = static_cast<std::int16_t>(drive.last.gyro_angle_cdeg - i % 2);
    drive.step(0, 0);
  }
  CHECK(drive.odometry.T_world_base().heading_rad == 0.0);
  drive.last.gyro_angle_cdeg = static_cast<std::int16_t>(drive.last.gyro_angle_cdeg - 100);
  drive.step(0, 0);
  CHECK(drive.odometry.T_world_base().heading_rad == Approx(-kPi / 180).epsilon(0.01));  // less a bit of drift
}

TEST_CASE("the drift seen at rest is subtracted while the base drives") {
  Drive drive;
  const auto drift_and_step = [&drive](int i, int ticks) {
    if (i % 5 == 0) drive.last.gyro_angle_cdeg = static_cast<std::int16_t>(drive.last.gyro_angle_cdeg - 1);
    drive.step(ticks, ticks);
  };
  for (int i = 0; i < 500; ++i) drift_and_step(i, 0);
  CHECK(drive.odometry.gyro_drift_cdegps() == Approx(-10.0).epsilon(0.03));
  for (int i = 0; i < 3000; ++i) drift_and_step(i, 50);
  // A minute at 6 degrees a minute, known to 3 %.
  CHECK(std::abs(drive.odometry.T_world_base().heading_rad) < 0.2 * kPi / 180);
  CHECK(std::abs(drive.odometry.T_world_base().y_m) < 0.02 * drive.odometry.T_world_base().x_m);
}

TEST_CASE("a gyro without drift is not corrected, however often the base sways as it stops") {
  Drive drive;
  for (int stop = 0; stop < 20; ++stop) {
    for (int i = 0; i < 50; ++i) drive.step(50, 50);
    for (int i = 0; i < 200; ++i) {
      if (i < 3) drive.last.gyro_angle_cdeg = static_cast<std::int16_t>(drive.last.gyro_angle_cdeg + (i == 1 ? 2 : -1));
      drive.step(0, 0);
    }
  }
  CHECK(drive.odometry.gyro_drift_cdegps() == 0.0);
  CHECK(drive.odometry.T_world_base().heading_rad == Approx(0.0).margin(1e-12));
}

TEST_CASE("turns that begin before the first tick are no drift, and are not lost") {
  Drive drive;
  int turned_cdeg = 0;
  for (int stop = 0; stop < 20; ++stop) {
    for (int i = 0; i < 150; ++i) {
      // Always the same way: a robot that goes round a building.
      const int turn_cdeg = i == 130 ? 1 : i == 149 ? 2 : 0;
      turned_cdeg += turn_cdeg;
      drive.last.gyro_angle_cdeg = static_cast<std::int16_t>(drive.last.gyro_angle_cdeg + turn_cdeg);
      drive.step(0, 0);
    }
    drive.step(0, 1);
    turned_cdeg += 2;  // the tick itself
    for (int i = 0; i < 50; ++i) drive.step(50, 50);
  }
  CHECK(drive.odometry.gyro_drift_cdegps() == 0.0);
  const double left_out_cdeg = turned_cdeg - drive.odometry.T_world_base().heading_rad * 18'000.0 / kPi;
  CHECK(std::abs(left_out_cdeg) < 0.01 * turned_cdeg);
}

TEST_CASE("a driven wheel that never ticks while the base goes on is dead") {
  for (const bool left_is_dead : {false, true}) {
    Drive drive;
    const auto step_with_dead_wheel = [&] {
      drive.step(60, 60);
      Feedback f = drive.last;
      (left_is_dead ? f.left_encoder_ticks : f.right_encoder_ticks) = 777;
      return f;
    };
    Odometry odometry;
    int packets = 0;
    for (; packets < 100 && !odometry.wheel_is_dead(); ++packets) odometry.update(step_with_dead_wheel());
    CHECK(odometry.dead_wheel() == (left_is_dead ? Wheel::left : Wheel::right));
    CHECK(packets == 26);  // the reference, then 0.5 s
    for (int i = 0; i < 100; ++i) odometry.update(step_with_dead_wheel());
    CHECK(odometry.wheel_is_dead());
  }
}

TEST_CASE("a wheel that stands while the base turns about it is not dead, nor one that is not driven") {
  Drive about_left;
  for (int i = 0; i < 200; ++i) {
    about_left.last.left_pwm = 20;
    about_left.step(0, 60);
    Feedback f = about_left.last;
    f.left_pwm = 20;
    about_left.odometry.update(f);
  }
  CHECK_FALSE(about_left.odometry.wheel_is_dead());
  Odometry pushed;
  Feedback f = first_packet();
  for (int i = 0; i < 200; ++i) {
    f = packet_after(f, 0, 60);
    f.gyro_angle_cdeg = 0;
    f.left_pwm = f.right_pwm = 0;
    pushed.update(f);
  }
  CHECK_FALSE(pushed.wheel_is_dead());
}

TEST_CASE("both wheels driven without a tick is a stall") {
  Drive drive;
  Feedback f = drive.last;
  for (int i = 0; i < 25; ++i) {
    CHECK_FALSE(drive.odometry.is_stalled());
    f = packet_after(f, 0, 0);
    f.left_pwm = f.right_pwm = 30;
    drive.odometry.update(f);
  }
  CHECK(drive.odometry.is_stalled());
  CHECK_FALSE(drive.odometry.wheel_is_dead());
  drive.odometry.update(packet_after(f, 3, 3));
  CHECK_FALSE(drive.odometry.is_stalled());
}

TEST_CASE("wheels that stop from one packet to the next and stay driven are a stall sooner") {
  for (const int ticks : {10, 60}) {  // 0.04 and 0.26 m/s
    Drive drive;
    Feedback f = drive.last;
    for (int i = 0; i < 20; ++i) {
      f = packet_after(f, ticks, ticks);
      f.left_pwm = f.right_pwm = 60;
      drive.odometry.update(f);
      CHECK(drive.odometry.are_both_rolling());
    }
    int packets = 0;
    while (packets < 100 && !drive.odometry.is_stalled()) {
      f = packet_after(f, 0, 0);
      f.left_pwm = f.right_pwm = 60;
      drive.odometry.update(f);
      ++packets;
    }
    CHECK(packets == (ticks == 60 ? 10 : 25));
    CHECK_FALSE(drive.odometry.are_both_rolling());
  }
}

}  // namespace
