// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_driver.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "tests/support/driver_bench.hpp"
#include "tests/support/kobuki_packets.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kobuki;
using g3d::test::is_still;
using g3d::tests::frame_of;
using Bench = g3d::test::DriverBench;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kStep_ns = 20 * kMs;
using Bytes = std::vector<std::uint8_t>;

Bench driving(const Twist& wish) {
  Bench bench;
  bench.wish = wish;
  bench.steps(120);
  REQUIRE(bench.obeyed.forward_mps == Approx(wish.forward_mps).margin(0.002));
  REQUIRE(bench.obeyed.turn_radps == Approx(wish.turn_radps).margin(0.02));
  return bench;
}

}  // namespace

TEST_CASE("Each 20 ms a command goes out, whether feedback arrives or not") {
  Bench bench;
  bench.base = false;
  bench.wish = {0.3, 0.0};
  for (int i = 0; i < 50; ++i) {
    const std::size_t before = bench.heard.size();
    bench.step();
    REQUIRE(bench.heard.size() == before + 1);
    REQUIRE(bench.heard.back().base.has_value());
    REQUIRE(is_still(bench.obeyed));
  }
  CHECK(bench.has(Condition::silent_base));
  CHECK(bench.state().ticks == 50);
}

TEST_CASE("Between two ticks nothing is sent without need") {
  Bench bench = driving({0.3, 0.0});
  for (int i = 0; i < 9; ++i) {
    bench.now_ns += 2 * kMs;
    CHECK(bench.tick() == 0);
  }
  CHECK(bench.driver.next_tick_ns() == bench.now_ns + 2 * kMs);
  bench.now_ns += 2 * kMs;
  CHECK(bench.tick() > 0);
}

TEST_CASE("Ticks that come a little late keep to the grid") {
  Bench bench = driving({0.3, 0.0});
  const TimeNs grid_ns = bench.driver.next_tick_ns();
  for (int i = 0; i < 100; ++i) {
    bench.now_ns = bench.driver.next_tick_ns() + (i % 7) * kMs;
    bench.tick();
  }
  CHECK(bench.driver.next_tick_ns() == grid_ns + 100 * kStep_ns);
}

TEST_CASE("It drives as it is told, ramping up, and says where it is") {
  Bench bench;
  bench.wish = {0.4, 0.0};
  double last_mps = 0.0;
  for (int i = 0; i < 100; ++i) {
    bench.step();
    CHECK(bench.obeyed.forward_mps >= last_mps);
    CHECK(bench.obeyed.forward_mps - last_mps <= 0.5 * 0.02 + 0.002);
    last_mps = bench.obeyed.forward_mps;
  }
  CHECK(last_mps == Approx(0.4).margin(0.002));
  CHECK(bench.state().verdict.state == SafetyState::free);
  const double x_m = bench.state().T_world_base.x_m;
  bench.steps(50);
  CHECK(bench.state().T_world_base.x_m - x_m == Approx(0.4).margin(0.01));
  CHECK(bench.state().velocity.forward_mps == Approx(0.4).margin(0.01));
  CHECK(bench.state().commanded == bench.wish);
  CHECK(bench.state().packets == 150);
  CHECK(bench.state().battery_v == Approx(15.9).margin(0.1));
  CHECK(bench.state().stamp_ns == bench.now_ns);
  CHECK(bench.state().feedback_ns == bench.now_ns);
}

TEST_CASE("Bumper, cliff and wheel drop are answered with zero at once, between two ticks") {
  struct Flag {
    std::function<void(Feedback&)> set;
    Condition condition;
  };
  for (const Flag& flag : {Flag{[](Feedback& f) { f.bumper = kBumperLeft; }, Condition::bumper},
                           Flag{[](Feedback& f) { f.cliff = kCliffCentre; }, Condition::cliff},
                           Flag{[](Feedback& f) { f.wheel_drop = kWheelDropRight; }, Condition::wheel_drop},
                           Flag{[](Feedback& f) { f.over_current = kOverCurrentLeft; }, Condition::over_current}}) {
    INFO(to_string(flag.condition));
    Bench bench = driving({0.5, 0.3});
    bench.now_ns += 7 * kMs;
    bench.next_packet();
    flag.set(bench.packet);
    bench.driver.on_bytes(frame_of(bench.packet), bench.now_ns);
    CHECK(bench.tick() == 10);  // base control alone, nothing to wait for
    CHECK(is_still(bench.obeyed));
    CHECK(bench.has(flag.condition));
    CHECK(bench.state().urgent_stops == 1);
    CHECK(bench.tick() == 0);  // said once; the next tick repeats it
    bench.now_ns = bench.driver.next_tick_ns();
    CHECK(bench.tick() > 0);
    CHECK(is_still(bench.obeyed));
  }
}

TEST_CASE("While the bumper is pressed it backs off slowly or turns, never forward") {
  Bench bench = driving({0.5, 0.0});
  bench.packet.bumper = kBumperLeft;
  bench.step();
  bench.packet.bumper = kBumperCentre;
  bench.step();
  CHECK(bench.state().bumper == (kBumperLeft | kBumperCentre));
  CHECK(bench.state().verdict.state == SafetyState::back_or_turn);
  bench.steps(50);
  CHECK(is_still(bench.obeyed));
  bench.wish = {-0.3, 0.0};
  bench.steps(50);
  CHECK(bench.obeyed.forward_mps == Approx(-0.1).margin(0.002));
  bench.wish = {0.0, 1.5};
  for (int i = 0; i < 50; ++i) {
    bench.step();
    REQUIRE(bench.obeyed.forward_mps <= 0.0);
  }
  CHECK(bench.obeyed.turn_radps == Approx(0.8).margin(0.02));
  bench.packet.bumper = 0;
  bench.wish = {0.5, 0.0};
  bench.steps(4);
  CHECK(bench.obeyed.forward_mps <= 0.0);
  bench.steps(60);
  CHECK(bench.obeyed.forward_mps > 0.3);
  CHECK(bench.state().bumper == 0);
  CHECK(bench.state().began[static_cast<std::size_t>(Condition::bumper)] == 1);
}

TEST_CASE("From forward to backing off at a contact there is no forward in between") {
  Bench bench = driving({0.5, 0.0});
  bench.packet.bumper = kBumperCentre;
  bench.wish = {-0.1, 0.0};
  for (int i = 0; i < 40; ++i) {
    bench.step();
    REQUIRE(bench.obeyed.forward_mps <= 0.0);
  }
  CHECK(bench.obeyed.forward_mps == Approx(-0.1).margin(0.002));
}

TEST_CASE("A dropped wheel stands until both are up for a second") {
  Bench bench = driving({0.5, 0.0});
  bench.packet.wheel_drop = kWheelDropLeft;
  bench.steps(10);
  CHECK(bench.state().wheel_drop == kWheelDropLeft);
  bench.packet.wheel_drop = 0;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(is_still(bench.obeyed));
    bench.step();
  }
  bench.steps(60);
  CHECK(bench.obeyed.forward_mps > 0.3);
}

TEST_CASE("A silent line is seen within 60 ms of its last packet, and zeros go on") {
  Bench bench = driving({0.5, 0.0});
  const TimeNs last_ns = bench.now_ns;
  bench.base = false;
  while (!is_still(bench.obeyed)) bench.step();
  CHECK(bench.now_ns - last_ns <= 60 * kMs);
  CHECK(bench.has(Condition::silent_base));
  const std::size_t heard = bench.heard.size();
  bench.steps(10);
  CHECK(bench.heard.size() == heard + 10);
  CHECK(is_still(bench.obeyed));
  // At least five more zeros once it speaks again.
  bench.base = true;
  for (int i = 0; i < 4; ++i) {
    bench.step();
    CHECK(is_still(bench.obeyed));
  }
  bench.steps(60);
  CHECK(bench.obeyed.forward_mps > 0.3);
}

TEST_CASE("A silent line is seen between two ticks as well") {
  Bench bench = driving({0.5, 0.0});
  const TimeNs last_ns = bench.now_ns;
  while (!is_still(bench.obeyed)) {
    bench.now_ns += 1 * kMs;
    bench.driver.set_command(bench.wish, bench.now_ns);
    bench.tick();
  }
  CHECK(bench.now_ns - last_ns <= 47 * kMs);
}

TEST_CASE("A stale command is stopped within 200 ms, and a new one drives on") {
  Bench bench = driving({0.5, 0.5});
  const TimeNs last_ns = bench.now_ns;
  bench.commander = false;
  while (!is_still(bench.obeyed)) bench.step();
  CHECK(bench.now_ns - last_ns <= 200 * kMs);
  CHECK(bench.state().verdict.reason == Condition::stale_command);
  bench.steps(100);
  CHECK(is_still(bench.obeyed));
  bench.commander = true;
  bench.steps(10);
  CHECK_FALSE(is_still(bench.obeyed));
}

TEST_CASE("Without images it stands, and goes on with the next") {
  Bench bench = driving({0.5, 0.0});
  bench.camera = false;
  bench.steps(16);
  CHECK_FALSE(is_still(bench.obeyed));
  bench.steps(3);
  CHECK(is_still(bench.obeyed));
  CHECK(bench.state().verdict.reason == Condition::silent_camera);
  bench.camera = true;
  bench.steps(10);
  CHECK_FALSE(is_still(bench.obeyed));
}

TEST_CASE("A thread that was late stands before it goes on") {
  Bench bench = driving({0.5, 0.0});
  bench.now_ns += 300 * kMs;
  bench.driver.set_command(bench.wish, bench.now_ns);
  bench.driver.set_camera_alive(bench.now_ns);
  bench.tick();
  CHECK(is_still(bench.obeyed));
  CHECK(bench.has(Condition::late_thread));
  bench.packet.timestamp_ms = static_cast<std::uint16_t>(bench.packet.timestamp_ms + 300);
  bench.steps(20);
  CHECK_FALSE(is_still(bench.obeyed));
}

TEST_CASE("An e-stop stops at once and is never resumed by itself") {
  Bench bench = driving({0.5, 0.0});
  bench.driver.set_e_stop(true);
  bench.now_ns += 1 * kMs;
  CHECK(bench.tick() == 10);
  CHECK(is_still(bench.obeyed));
  CHECK_FALSE(bench.driver.resume());
  bench.now_ns += 19 * kMs;
  bench.driver.set_e_stop(false);
  bench.now_ns -= 20 * kMs;
  for (int i = 0; i < 200; ++i) {
    bench.step();
    REQUIRE(is_still(bench.obeyed));
  }
  CHECK(bench.driver.resume());
  bench.steps(20);
  CHECK_FALSE(is_still(bench.obeyed));
}

TEST_CASE("It backs off where it came from, and nowhere else unless somebody knows") {
  Bench bench = driving({0.3, 0.0});
  bench.rear_is_free = false;
  bench.wish = {};
  bench.steps(60);
  bench.wish = {-0.15, 0.0};
  bench.steps(30);
  CHECK(bench.obeyed.forward_mps == Approx(-0.15).margin(0.002));
  // Half a turn: what is behind now was ahead before.
  bench.wish = {0.0, 1.5};
  bench.steps(20);
  while (std::abs(bench.state().T_world_base.heading_rad) < 2.6) bench.step();
  bench.wish = {};
  bench.steps(10);
  const double there_m = bench.state().T_world_base.x_m;
  bench.wish = {-0.15, 0.0};
  bench.steps(300);
  CHECK(is_still(bench.obeyed));
  CHECK(bench.has(Condition::rear_unknown));
  CHECK(std::abs(bench.state().T_world_base.x_m - there_m) < 0.7);
  bench.rear_is_free = true;
  bench.steps(30);
  CHECK(bench.obeyed.forward_mps == Approx(-0.15).margin(0.002));
}

TEST_CASE("Wishes that are not numbers or from the past do not move it") {
  Bench bench = driving({0.3, 0.0});
  bench.wish = {std::numeric_limits<double>::quiet_NaN(), 0.0};
  bench.steps(1);
  CHECK(is_still(bench.obeyed));
  CHECK(bench.state().refused_wishes == 1);
  bench.wish = {};
  bench.steps(1);
  bench.driver.set_command({0.5, 0.0}, bench.now_ns - 40 * kMs);
  bench.commander = false;
  bench.steps(3);
  CHECK(is_still(bench.obeyed));
}

TEST_CASE("Versions are asked for until they are answered, and only of a base that is there") {
  Bench bench;
  bench.base = false;
  bench.steps(100);
  for (const Command& command : bench.heard) CHECK_FALSE(command.request_extra.has_value());
  bench.base = true;
  bench.steps(105);
  std::size_t asked = 0;
  for (const Command& command : bench.heard) asked += command.request_extra == kAskAll;
  CHECK(asked >= 4);
  CHECK(asked <= 5);
  bench.answer_versions();
  bench.heard.clear();
  bench.steps(100);
  for (const Command& command : bench.heard) CHECK_FALSE(command.request_extra.has_value());
  CHECK(bench.state().device.firmware == std::array<std::uint8_t, 3>{1, 2, 0});
  CHECK_FALSE(bench.has(Condition::wrong_firmware));
}

TEST_CASE("The Kinect's rail is on in every word of outputs, which is repeated each second") {
  Bench bench = driving({0.3, 0.0});
  bench.packet.bumper = kBumperLeft;
  bench.steps(60);
  std::size_t words = 0;
  bool orange = false, green = false;
  for (const Command& command : bench.heard) {
    if (!command.outputs) continue;
    ++words;
    CHECK((*command.outputs & kAllRails) == kAllRails);
    green |= (*command.outputs & (kLed1Red | kLed1Green)) == kLed1Green;
    orange |= (*command.outputs & (kLed1Red | kLed1Green)) == (kLed1Red | kLed1Green);
  }
  CHECK(words >= 4);
  CHECK(words <= 12);
  CHECK(green);
  CHECK(orange);
}

TEST_CASE("Farewell: zeros, LEDs off, rails on") {
  Bench bench = driving({0.5, 0.0});
  std::array<std::uint8_t, BaseDriver::kMaxOut_bytes> out;
  const std::size_t size = bench.driver.farewell(out);
  bench.heard.clear();
  bench.hear({out.data(), size});
  REQUIRE(bench.heard.size() == 1);
  CHECK(is_still(bench.obeyed));
  CHECK(bench.heard[0].outputs == kAllRails);
}

TEST_CASE("Garbage, cut and lost bytes are counted and never move it") {
  Bench bench = driving({0.3, 0.0});
  std::uint32_t seed = 1;
  const auto random = [&seed] { return seed = seed * 1664525U + 1013904223U, seed >> 16; };
  Bytes noise(4'000);
  for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
  bench.base = false;
  const double x_m = bench.state().T_world_base.x_m;
  for (int i = 0; i < 50; ++i) {
    bench.driver.on_bytes(std::span(noise).subspan(static_cast<std::size_t>(i) * 80, 80), bench.now_ns + kStep_ns);
    bench.step();
  }
  CHECK(is_still(bench.obeyed));
  CHECK(bench.state().T_world_base.x_m - x_m < 0.02);
  CHECK(bench.state().rejects.skipped_bytes > 3'000);
  CHECK(bench.state().received_bytes > 4'000);
}

TEST_CASE("Feedback that grows old stands") {
  Bench bench = driving({0.3, 0.0});
  // From the tenth on nothing is lost, but each comes 100 ms late.
  std::vector<Bytes> under_way;
  std::size_t arrived = 0;
  for (std::size_t i = 0; i < 40; ++i) {
    bench.now_ns += kStep_ns;
    bench.next_packet();
    under_way.push_back(frame_of(bench.packet));
    while (arrived < under_way.size() && (arrived < 10 || arrived + 5 <= i)) {
      bench.driver.on_bytes(under_way[arrived++], bench.now_ns);
    }
    bench.driver.set_command(bench.wish, bench.now_ns);
    bench.driver.set_camera_alive(bench.now_ns);
    bench.tick();
  }
  CHECK_FALSE(bench.has(Condition::silent_base));
  CHECK(bench.has(Condition::late_base));
  CHECK(is_still(bench.obeyed));
}

TEST_CASE("The same bytes at the same times give the same bytes") {
  Bench one = driving({0.4, 0.7});
  Bench two = driving({0.4, 0.7});
  CHECK(one.heard == two.heard);
  CHECK(one.state().T_world_base == two.state().T_world_base);
}
