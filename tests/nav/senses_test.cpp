// SPDX-License-Identifier: Apache-2.0
#include "nav/senses.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/sim/sim_building.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

constexpr hal::TimeNs kMs = 1'000'000;
constexpr double kQuarter_rad = 1.57079632679489661923;

/// Odometry drives ahead at 0.5 m/s; the camera sees a tilted plane with a little noise.
struct Rig {
  SensesConfig config = [] {
    SensesConfig c;
    c.camera = hal::scaled_kinect(64, 48);
    c.T_base_camera = hal::forward_camera(0.5);
    c.T_world_start = {2.0, 1.0, kQuarter_rad};
    return c;
  }();
  Senses senses{config};
  hal::kobuki::PoseHistory poses;
  hal::Frame frame;
  std::uint32_t seed = 1;

  Rig() {
    frame.depth = std::make_unique<std::uint16_t[]>(config.camera.pixel_count());
    for (int i = 0; i <= 50; ++i) poses.add(i * 20 * kMs, {0.01 * i, 0.0, 0.0});
  }
  Sight look(hal::TimeNs stamp_ns, hal::TimeNs age_ns = 30 * kMs, bool garbage = false) {
    frame.stamp_ns = stamp_ns;
    for (std::size_t i = 0; i < config.camera.pixel_count(); ++i) {
      seed = seed * 1664525U + 1013904223U;
      frame.depth[i] = static_cast<std::uint16_t>(garbage ? seed >> 16 : 1500 + 10 * (i % 64) + (seed >> 16) % 4);
    }
    return senses.look(frame, poses, stamp_ns + age_ns);
  }
};

}  // namespace

TEST_CASE("a frame gets the pose of its own moment, in the frame of the world") {
  Rig rig;
  const Sight sight = rig.look(490 * kMs);
  CHECK_FALSE(sight.refused);
  CHECK(sight.is_alive);
  // 0.245 m ahead of a start that looks along +y
  CHECK(sight.T_world_base.x_m == Approx(2.0).margin(1e-9));
  CHECK(sight.T_world_base.y_m == Approx(1.245));
  CHECK(sight.T_world_base.heading_rad == Approx(kQuarter_rad));
  CHECK(sight.T_world_camera.translation_m[1] == Approx(1.245));
  CHECK(sight.T_world_camera.translation_m[2] == Approx(0.5));
}

TEST_CASE("headings stay within half a turn") {
  SensesConfig config;
  config.T_world_start.heading_rad = 3.0;
  CHECK(Senses(config).in_world({0.0, 0.0, 1.0}).heading_rad == Approx(4.0 - 4 * kQuarter_rad));
}

TEST_CASE("a frame that is no later than the one before is refused, whatever it shows") {
  Rig rig;
  CHECK_FALSE(rig.look(400 * kMs).refused);
  const Sight again = rig.look(400 * kMs);
  CHECK(again.refused == hal::DropReason::time_backwards);
  CHECK_FALSE(again.is_alive);
  CHECK(rig.look(390 * kMs).refused == hal::DropReason::time_backwards);
  CHECK_FALSE(rig.look(401 * kMs).refused);
}

TEST_CASE("a frame from a time of which odometry knows nothing is refused") {
  Rig rig;
  CHECK(rig.look(-20 * kMs).refused == hal::DropReason::no_pose);
  CHECK_FALSE(rig.look(1'030 * kMs).refused);  // a little ahead of the newest packet
  CHECK(rig.look(1'500 * kMs).refused == hal::DropReason::no_pose);
  const hal::kobuki::PoseHistory nothing;
  rig.frame.stamp_ns = 1'600 * kMs;
  CHECK(rig.senses.look(rig.frame, nothing, 1'600 * kMs).refused == hal::DropReason::no_pose);
}

TEST_CASE("noise is refused and does not count as sight") {
  Rig rig;
  const Sight sight = rig.look(400 * kMs, 30 * kMs, true);
  CHECK(sight.refused == hal::DropReason::unreadable_depth);
  CHECK_FALSE(sight.is_alive);
}

TEST_CASE("an old frame is mapped where it was taken, but does not count as sight") {
  Rig rig;
  const Sight sight = rig.look(400 * kMs, 500 * kMs);
  CHECK_FALSE(sight.refused);
  CHECK_FALSE(sight.is_alive);
  CHECK(sight.T_world_base.y_m == Approx(1.2));
}

TEST_CASE("the navigator feels what the base says, in the world") {
  Rig rig;
  hal::kobuki::BaseState base;
  base.T_world_base = {1.0, 0.0, 0.0};
  base.velocity = {0.2, 0.3};
  base.bumper = 4;
  base.cliff = 1;
  base.verdict.state = hal::SafetyState::free;
  const BaseView view = rig.senses.feel(base);
  CHECK(view.T_world_base.x_m == Approx(2.0).margin(1e-9));
  CHECK(view.T_world_base.y_m == Approx(2.0));
  CHECK(view.velocity == hal::Twist{0.2, 0.3});
  CHECK(view.bumper == 4);
  CHECK(view.cliff == 1);
  CHECK(view.verdict.state == hal::SafetyState::free);
}

TEST_CASE("A low battery is felt once, and what it still gives is told") {
  Rig rig;
  hal::kobuki::BaseState base;
  base.energy_left_s = 321.0;
  CHECK(rig.senses.feel(base).energy_left_s == 321.0);
  CHECK_FALSE(rig.senses.feels_battery_low(base));
  base.battery_level = hal::kobuki::BatteryLevel::low;
  CHECK(rig.senses.feels_battery_low(base));
  base.battery_level = hal::kobuki::BatteryLevel::critical;
  CHECK_FALSE(rig.senses.feels_battery_low(base));
}
