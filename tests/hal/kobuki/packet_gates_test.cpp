// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/packet_gates.hpp"

#include <catch2/catch.hpp>

#include "tests/support/kobuki_packets.hpp"

namespace {

using namespace g3d::hal::kobuki;
using g3d::tests::first_packet;
using g3d::tests::packet_after;

template <typename Change>
std::optional<Reject> value_verdict(Change&& change) {
  Feedback feedback = first_packet();
  change(feedback);
  return impossible_value(feedback);
}

template <typename Change>
std::optional<Reject> step_verdict(Change&& change) {
  const Feedback first = first_packet();
  Feedback next = packet_after(first, 0, 0);
  change(next);
  return impossible_step(first, next);
}

TEST_CASE("possible values pass") {
  CHECK_FALSE(impossible_value(first_packet()));
  CHECK_FALSE(value_verdict([](Feedback& f) { f.bumper = f.cliff = f.buttons = 7; }));
  CHECK_FALSE(value_verdict([](Feedback& f) { f.wheel_drop = f.over_current = 3; }));
  CHECK_FALSE(value_verdict([](Feedback& f) { f.battery_decivolts = 90; }));
  CHECK_FALSE(value_verdict([](Feedback& f) { f.battery_decivolts = 180; }));
  CHECK_FALSE(value_verdict([](Feedback& f) { f.gyro_angle_cdeg = -18'000; }));
}

TEST_CASE("values that no base can have do not") {
  CHECK(value_verdict([](Feedback& f) { f.bumper = 8; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.wheel_drop = 4; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.cliff = 0x80; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.over_current = 4; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.buttons = 8; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.dock_ir[2] = 0x40; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.cliff_adc[1] = 4096; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.analog_in[3] = 4096; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.gyro_angle_cdeg = 18'001; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.gyro_rate_cdegps = -30'001; }) == Reject::impossible_value);
  CHECK(value_verdict([](Feedback& f) { f.battery_decivolts = 89; }) == Reject::battery_voltage);
  CHECK(value_verdict([](Feedback& f) { f.battery_decivolts = 181; }) == Reject::battery_voltage);
}

TEST_CASE("the fastest drive passes, over all wraps") {
  Feedback last = first_packet();
  for (int i = 0; i < 4000; ++i) {
    const bool turns = i / 100 % 2 == 0;
    const Feedback next = packet_after(last, turns ? -100 : 164, turns ? 100 : 164);
    REQUIRE_FALSE(impossible_step(last, next));
    last = next;
  }
}

TEST_CASE("a step must take 1 to 200 ms") {
  const auto verdict_after = [](int ms) {
    return step_verdict([ms](Feedback& f) {
      f.timestamp_ms = static_cast<std::uint16_t>(first_packet().timestamp_ms + ms);
      f.gyro_sample_count = 0;
    });
  };
  CHECK(verdict_after(0) == Reject::time_step);
  CHECK_FALSE(verdict_after(1));
  CHECK_FALSE(verdict_after(200));
  CHECK(verdict_after(201) == Reject::time_step);
  CHECK(verdict_after(-20) == Reject::time_step);
}

TEST_CASE("a wheel gets no further than half as fast again as it can") {
  CHECK(max_ticks_in(20) == 247);
  for (const int sign : {-1, 1}) {
    const auto moved = [sign](int ticks) { return static_cast<std::uint16_t>(sign * ticks); };
    CHECK_FALSE(step_verdict([&](Feedback& f) { f.left_encoder_ticks += moved(247); }));
    CHECK(step_verdict([&](Feedback& f) { f.left_encoder_ticks += moved(248); }) == Reject::encoder_step);
    CHECK(step_verdict([&](Feedback& f) { f.right_encoder_ticks += moved(248); }) == Reject::encoder_step);
  }
}

TEST_CASE("the gyro turns no faster than it can measure") {
  const auto verdict_turned = [](int cdeg) {
    return step_verdict([cdeg](Feedback& f) {
      int angle = first_packet().gyro_angle_cdeg + cdeg;
      if (angle > 18'000) angle -= 36'000;
      f.gyro_angle_cdeg = static_cast<std::int16_t>(angle);
    });
  };
  CHECK(max_angle_in_cdeg(20) == 650);
  CHECK_FALSE(verdict_turned(650));
  CHECK_FALSE(verdict_turned(-650));
  CHECK(verdict_turned(651) == Reject::gyro_angle_step);
  CHECK(verdict_turned(-651) == Reject::gyro_angle_step);
}

TEST_CASE("angles are taken the short way round") {
  CHECK(angle_between_cdeg(17'950, -17'950) == 100);
  CHECK(angle_between_cdeg(-17'950, 17'950) == -100);
  CHECK(angle_between_cdeg(-18'000, 18'000) == 0);
  CHECK(angle_between_cdeg(0, 18'000) == 18'000);
  CHECK(angle_between_cdeg(-32'768, 32'767) == 65'535 - 72'000);
}

TEST_CASE("raw gyro samples come at their rate") {
  const auto verdict_after = [](int samples) {
    return step_verdict([samples](Feedback& f) {
      f.gyro_frame_id = static_cast<std::uint8_t>(first_packet().gyro_frame_id + samples);
    });
  };
  for (int samples = 0; samples <= 4; ++samples) CHECK_FALSE(verdict_after(samples));
  CHECK(verdict_after(5) == Reject::gyro_frame_step);
  CHECK(verdict_after(-1) == Reject::gyro_frame_step);
  CHECK_FALSE(step_verdict([](Feedback& f) {
    f.gyro_frame_id = 100;
    f.gyro_sample_count = 0;
  }));
}

}  // namespace
