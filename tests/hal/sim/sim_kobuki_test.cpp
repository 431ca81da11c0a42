// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_kobuki.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/kobuki/packet_reader.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;
using kobuki::Feedback;

namespace {

constexpr TimeNs kMs = 1'000'000;

KobukiFaults with(bool KobukiFaults::*fault) {
  KobukiFaults faults;
  faults.*fault = true;
  return faults;
}

/// A base with its body in an endless hall, and a host that reads what it says.
struct Bench {
  explicit Bench(const SimKobukiOptions& options = {}, const char* text = "floor 0 0 0 200 200 0.1\n")
      : world(parse_world(text, "w").value()), floor(world), body(floor, {}, -1, {}), base(options) {
    body.place({}, {});
    base.sense(body);
    base.advance_to(0);
  }
  void run(int duration_ms) {
    for (int t = 0; t < duration_ms; t += 2) {
      now += 2 * kMs;
      body.command(base.drive().speed_mmps, base.drive().radius_mm);
      body.step(0.002, {});
      base.sense(body);
      base.advance_to(now);
      std::array<std::uint8_t, 512> bytes;
      for (std::size_t n = base.read(bytes); n > 0; n = base.read(bytes)) {
        reader.feed(std::span(bytes).first(n), now, [&](const Feedback& f) { got.push_back(f); });
      }
    }
  }
  void say(const kobuki::Command& command) {
    std::array<std::uint8_t, kobuki::kMaxCommand_bytes> bytes;
    REQUIRE(base.write(std::span(bytes).first(kobuki::encode_command(command, bytes))));
  }
  void drive(double forward_mps, double turn_radps) {
    kobuki::Command command;
    command.base = kobuki::to_base_control({forward_mps, turn_radps});
    say(command);
  }

  World world;
  FloorContact floor;
  RobotBody body;
  SimKobuki base;
  kobuki::PacketReader reader;
  std::vector<Feedback> got;
  TimeNs now = 0;
};

}  // namespace

TEST_CASE("packets come every 20 ms by the base's own clock, which wraps") {
  SimKobukiOptions options;
  options.first_timestamp_ms = 65000;
  Bench bench(options);
  bench.run(2000);
  REQUIRE(bench.got.size() == 101);
  for (std::size_t i = 0; i < bench.got.size(); ++i) {
    REQUIRE(bench.got[i].timestamp_ms == static_cast<std::uint16_t>(65000 + 20 * i));
    REQUIRE(bench.got[i].received_ns == static_cast<TimeNs>(i == 0 ? 2 : 20 * i) * kMs);
  }
  CHECK(bench.reader.rejects().total() == 0);
  options.clock_ppm = 50000;
  Bench fast(options);
  fast.run(2000);
  CHECK(fast.got.size() == 106);
}

TEST_CASE("with everything off, encoders and gyro are exact to a tick and 0.01 degrees, through all wraps") {
  SimKobukiOptions options;
  options.first_left_ticks = 65530;
  options.first_angle_deg = 179.0;
  Bench bench(options);
  std::int64_t left = 0;
  std::int64_t right = 0;
  for (const auto& [v, w] : {std::pair{0.5, 0.3}, {0.3, -1.0}, {-0.2, 0.4}, {0.0, 1.5}, {0.6, 0.0}, {0.6, 0.1}}) {
    bench.drive(v, w);
    bench.run(4000);
  }
  bench.drive(0, 0);
  bench.run(1000);
  for (std::size_t i = 1; i < bench.got.size(); ++i) {
    left += static_cast<std::int16_t>(bench.got[i].left_encoder_ticks - bench.got[i - 1].left_encoder_ticks);
    right += static_cast<std::int16_t>(bench.got[i].right_encoder_ticks - bench.got[i - 1].right_encoder_ticks);
  }
  CHECK(left * kobuki::kMetresPerTick == Approx(bench.body.wheel_way_m().left).margin(1e-4));
  CHECK(right * kobuki::kMetresPerTick == Approx(bench.body.wheel_way_m().right).margin(1e-4));
  const double angle = bench.got.back().gyro_angle_cdeg / 100.0;
  const double truth = 179.0 + bench.body.turned_rad() * 180.0 / std::numbers::pi;
  CHECK(std::remainder(angle - truth, 360.0) == Approx(0.0).margin(0.0051));
  CHECK(bench.reader.rejects().total() == 0);
}

TEST_CASE("the gyro errs as asked, and repeats by its seed") {
  SimKobukiOptions options;
  options.gyro_bias_radps = 0.001;
  Bench biased(options);
  biased.run(20000);
  CHECK(biased.got.back().gyro_angle_cdeg == Approx(2.0 * 0.01 * 180 / std::numbers::pi * 100).margin(3));
  options.gyro_bias_radps = 0.0;
  options.gyro_noise_radps = 0.01;
  options.gyro_drift_radps_per_sqrt_s = 0.001;
  Bench a(options);
  Bench b(options);
  options.seed = 2;
  Bench c(options);
  for (Bench* bench : {&a, &b, &c}) bench->run(10000);
  CHECK(a.got.back().gyro_angle_cdeg != 0);
  CHECK(a.got.back().gyro_angle_cdeg == b.got.back().gyro_angle_cdeg);
  CHECK(a.got.back().gyro_angle_cdeg != c.got.back().gyro_angle_cdeg);
  double sum = 0;
  for (const Feedback& f : a.got) sum += f.gyro[0].z * f.gyro[0].z;
  CHECK(std::sqrt(sum / static_cast<double>(a.got.size())) * 0.00875 * std::numbers::pi / 180 ==
        Approx(0.01).epsilon(0.25));
}

TEST_CASE("it keeps the last command for ever") {
  Bench bench;
  bench.drive(0.2, 0);
  bench.run(10000);
  CHECK(bench.body.velocity().forward_mps == Approx(0.2));
  CHECK(bench.base.drive_commands() == 1);
}

TEST_CASE("requests are answered once") {
  SimKobukiOptions options;
  options.firmware = {1, 1, 4};
  Bench bench(options);
  bench.run(100);
  CHECK_FALSE(bench.reader.info().has_firmware);
  kobuki::Command questions;
  questions.request_extra = kobuki::kAskAll;
  questions.get_gains = true;
  bench.say(questions);
  bench.run(100);
  CHECK(bench.reader.info().hardware == std::array<std::uint8_t, 3>{1, 0, 4});
  CHECK(bench.reader.info().firmware == std::array<std::uint8_t, 3>{1, 1, 4});
  CHECK(bench.reader.info().udid == std::array<std::uint32_t, 3>{98238259, 926504013, 1360618305});
  CHECK(bench.reader.gains().has_value());
  CHECK(bench.reader.rejects().total() == 0);
  kobuki::Command lights;
  lights.outputs = static_cast<std::uint16_t>(kobuki::kAllRails | kobuki::kLed1Green);
  bench.say(lights);
  bench.run(20);
  CHECK(bench.base.outputs() == (kobuki::kAllRails | kobuki::kLed1Green));
  CHECK(bench.base.kinect_has_power());
}

TEST_CASE("a blocked base tells of over-current and bumper, a draining one of its voltage") {
  SimKobukiOptions options;
  options.battery_life_s = 10.0;
  Bench bench(options, "floor 0 0 0 20 20 0.1\nbox 0.5 0 0 0.2 2 1\n");
  bench.drive(0.2, 0);
  bench.run(1000);
  CHECK(bench.got.back().over_current == 0);
  CHECK(bench.got.back().battery_decivolts == Approx(165 - 3).margin(1));
  bench.run(2000);
  CHECK(bench.got.back().bumper == kobuki::kBumperCentre);
  CHECK(bench.got.back().over_current == (kobuki::kOverCurrentLeft | kobuki::kOverCurrentRight));
  CHECK(bench.got.back().current_10mA[0] == 255);
  bench.drive(-0.2, 0);
  bench.run(8000);
  CHECK(bench.got.back().bumper == 0);
  CHECK(bench.got.back().over_current == 0);
  CHECK(bench.got.back().battery_decivolts == 132);
}

TEST_CASE("faults: silent, deaf, unplugged, dead encoder") {
  Bench bench;
  bench.drive(0.2, 0);
  bench.run(1000);
  const std::size_t before = bench.got.size();
  bench.base.set_faults(with(&KobukiFaults::silent));
  bench.run(1000);
  CHECK(bench.got.size() == before);
  bench.drive(0.1, 0);
  bench.base.set_faults(with(&KobukiFaults::deaf));
  bench.run(1000);
  CHECK(bench.got.size() == before + 49);  // after a silence one packet becomes the new reference
  bench.drive(0.0, 0);
  bench.run(1000);
  CHECK(bench.base.drive().speed_mmps == 100);
  bench.base.set_faults(with(&KobukiFaults::unplugged));
  CHECK(bench.base.state() == LineState::lost);
  CHECK_FALSE(bench.base.write(std::array<std::uint8_t, 1>{0}));
  bench.run(100);
  bench.base.set_faults(with(&KobukiFaults::left_dead));
  CHECK(bench.base.state() == LineState::up);
  bench.run(1000);
  const std::size_t last = bench.got.size() - 1;
  CHECK(bench.got[last].left_encoder_ticks == bench.got[last - 40].left_encoder_ticks);
  CHECK(bench.got[last].right_encoder_ticks != bench.got[last - 40].right_encoder_ticks);
  CHECK(bench.got[last].left_pwm != 0);
}

TEST_CASE("faults: stuck, slow and scrambled packets") {
  Bench bench;
  bench.drive(0.2, 0);
  bench.run(1000);
  const std::uint64_t sent = bench.base.packets_sent();
  KobukiFaults faults;
  faults.stuck = true;
  bench.base.set_faults(faults);
  const std::size_t before = bench.got.size();
  bench.run(1000);
  CHECK(bench.base.packets_sent() == sent + 50);
  CHECK(bench.got.size() <= before + 1);  // a base that repeats itself is a silent base
  faults = {};
  faults.keep_every = 5;
  bench.base.set_faults(faults);
  bench.run(2000);
  CHECK(bench.base.packets_sent() == sent + 70);
  faults = {};
  faults.scrambled = true;
  bench.base.set_faults(faults);
  const std::uint64_t rejected = bench.reader.rejects().total();
  bench.run(1000);
  CHECK(bench.reader.rejects().total() > rejected + 40);
}

TEST_CASE("a noisy, late line loses packets but the base goes on") {
  SimKobukiOptions options;
  options.to_host = {.corrupt = 0.001, .lose = 0.001, .insert = 0.001, .latency_ns = 30 * kMs};
  options.to_base = {.latency_ns = 40 * kMs};
  Bench bench(options);
  bench.drive(0.2, 0);
  bench.run(38);
  CHECK(bench.base.drive().speed_mmps == 0);
  bench.run(4);
  CHECK(bench.base.drive().speed_mmps == 200);
  bench.run(10000);
  CHECK(bench.got.size() > 300);
  CHECK(bench.got.size() < 490);
  CHECK(bench.reader.rejects().total() > 20);
}

TEST_CASE("noise of the gyro makes its angle walk by a tenth of its sigma in a second") {
  double square_deg2 = 0.0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    SimKobukiOptions options;
    options.seed = seed;
    options.gyro_noise_radps = 10.0 * 0.5 * std::numbers::pi / 180.0;
    Bench bench(options);
    bench.run(4000);
    const double angle_deg = bench.got.back().gyro_angle_cdeg / 100.0;
    square_deg2 += angle_deg * angle_deg / 16.0;
  }
  CHECK(std::sqrt(square_deg2) > 0.6);
  CHECK(std::sqrt(square_deg2) < 1.5);
}
