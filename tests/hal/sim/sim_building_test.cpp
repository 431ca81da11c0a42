// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sim_building.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/frame_pool.hpp"
#include "hal/kobuki/command.hpp"
#include "hal/kobuki/odometry.hpp"
#include "hal/kobuki/packet_reader.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d::hal;

namespace {

constexpr TimeNs kSecond = 1'000'000'000;

void drive(SimBuilding& building, std::size_t robot, double forward_mps, double turn_radps) {
  std::array<std::uint8_t, kobuki::kMaxCommand_bytes> bytes;
  const std::size_t n = kobuki::encode_base_control({forward_mps, turn_radps}, bytes);
  REQUIRE(building.line(robot).write(std::span(bytes).first(n)));
}

SimBuildingOptions options_for(std::vector<PlanarPose> starts, int threads = 1) {
  SimBuildingOptions options;
  options.camera = scaled_kinect(160, 120);
  options.threads = threads;
  for (const PlanarPose& start : starts) {
    SimRobotOptions robot;
    robot.T_world_base = start;
    options.robots.push_back(robot);
  }
  return options;
}

World world_of(const char* text) { return parse_world(text, "w").value(); }

/// FNV-1a.
std::uint64_t mixed(std::uint64_t hash, const void* data, std::size_t size_bytes) {
  for (std::size_t i = 0; i < size_bytes; ++i) {
    hash = (hash ^ static_cast<const std::uint8_t*>(data)[i]) * 1099511628211ULL;
  }
  return hash;
}

/// Two robots and somebody walking, in a fixed program of commands; everything that comes out as one number.
std::uint64_t fingerprint(int threads, std::uint64_t seed) {
  SimBuildingOptions options = options_for({{-2, 0, 0}, {2, 0.5, 3.0}}, threads);
  options.seed = seed;
  options.robots[1].base.gyro_noise_radps = 0.01;
  SimBuilding building(load_world("visitor").value(), options);
  Frame frame = make_frame(building.camera());
  std::uint64_t hash = 14695981039346656037ULL;
  for (int i = 0; i < 80; ++i) {
    drive(building, 0, 0.2, i % 20 < 10 ? 0.5 : -0.5);
    drive(building, 1, 0.1, 0.3);
    building.advance_to((i + 1) * kSecond / 10);
    for (std::size_t robot = 0; robot < 2; ++robot) {
      building.render(robot, frame);
      hash = mixed(hash, frame.depth.get(), 2 * building.camera().pixel_count());
      hash = mixed(hash, frame.rgb.get(), 3 * building.camera().pixel_count());
      std::array<std::uint8_t, 1024> bytes;
      hash = mixed(hash, bytes.data(), building.line(robot).read(bytes));
      const PlanarPose pose = building.T_world_base(robot);
      hash = mixed(hash, &pose, sizeof pose);
    }
  }
  return hash;
}

}  // namespace

TEST_CASE("a run repeats to the last bit, on any number of threads", "[slow]") {
  const std::uint64_t once = fingerprint(1, 5);
  CHECK(fingerprint(1, 5) == once);
  CHECK(fingerprint(3, 5) == once);
  CHECK(fingerprint(1, 6) != once);
}

TEST_CASE("time goes in whole steps whatever the calls are") {
  SimBuilding a(world_of("floor 0 0 0 20 20 0.1\n"), options_for({{0, 0, 0}}));
  SimBuilding b(world_of("floor 0 0 0 20 20 0.1\n"), options_for({{0, 0, 0}}));
  drive(a, 0, 0.4, 0.3);
  drive(b, 0, 0.4, 0.3);
  a.advance_to(kSecond);
  for (TimeNs t = 0; t <= kSecond; t += 777'777) b.advance_to(t);
  b.advance_to(kSecond);
  CHECK(a.now() == kSecond);
  CHECK(a.T_world_base(0) == b.T_world_base(0));
  CHECK(a.T_world_base(0).x_m > 0.3);
}

TEST_CASE("odometry from the bytes is the truth to a millimetre, unless drift is asked for") {
  for (const double drift : {0.0, 1.0}) {
    SimBuildingOptions options = options_for({{0, 0, 0}});
    add_drift(options.robots[0], drift, 3);
    SimBuilding building(world_of("floor 0 0 0 400 400 0.1\n"), options);
    kobuki::PacketReader reader;
    kobuki::Odometry odometry;
    SeededRandom random(1);
    double worst_m = 0.0;
    for (int i = 0; i < 120; ++i) {
      drive(building, 0, 0.5 * random.uniform(), 2.4 * (random.uniform() - 0.5));
      building.advance_to((i + 1) * kSecond);
      std::array<std::uint8_t, 8192> bytes;
      reader.feed(std::span(bytes).first(building.line(0).read(bytes)), building.now(),
                  [&](const kobuki::Feedback& f) { odometry.update(f); });
      const PlanarPose truth = building.T_world_base(0);
      const PlanarPose& told = odometry.T_world_base();
      worst_m = std::max(worst_m, std::hypot(told.x_m - truth.x_m, told.y_m - truth.y_m));
    }
    CHECK(building.record(0).driven_m > 20.0);
    CHECK(reader.rejects().total() == 0);
    if (drift == 0.0) {
      CHECK(worst_m < 0.001);
    } else {
      CHECK(worst_m > 0.02);
    }
  }
}

TEST_CASE("robots see one another as they are now, but not themselves") {
  SimBuildingOptions options = options_for({{0, 0, 0}, {2, 0, 0}});
  options.noise = false;
  SimBuilding building(world_of("floor 0 0 0 40 40 0.1\nbox 10 0 0 0.2 20 3\n"), options);
  Frame frame = make_frame(building.camera());
  const std::size_t middle = 60 * 160 + 80;
  building.render(0, frame);
  CHECK(frame.depth[middle] == Approx(2000 - 178).margin(2));
  CHECK(frame.stamp_ns == 0);
  building.render(1, frame);
  CHECK(frame.depth[middle] == Approx(7900).margin(2));
  drive(building, 1, 0.3, 0);
  building.advance_to(4 * kSecond);
  building.render(0, frame);
  const double gap_m = building.T_world_base(1).x_m - 0.178;
  CHECK(gap_m > 2.7);
  CHECK(frame.depth[middle] == Approx(1000 * gap_m).margin(2));
  CHECK(frame.sequence == 1);
}

TEST_CASE("contacts are told apart by what the camera could have measured", "[slow]") {
  SimBuilding seen(world_of("floor 0 0 0 20 20 0.1\nbox 2 0 0 0.2 4 2\n"), options_for({{0, 0, 0}}));
  Frame frame = make_frame(seen.camera());
  drive(seen, 0, 0.3, 0);
  for (int i = 0; i < 80; ++i) {
    seen.render(0, frame);
    seen.advance_to((i + 1) * kSecond / 10);
  }
  CHECK(seen.record(0).contacts == 1);
  CHECK(seen.record(0).contacts_measurable == 1);
  CHECK(seen.record(0).fastest_contact_mps == Approx(0.3));
  CHECK(seen.record(0).closest_clearance_m == Approx(0.0).margin(0.0005));
  REQUIRE(seen.record(0).events.size() == 1);
  CHECK(seen.record(0).events[0].solid == 1);
  CHECK(seen.record(0).events[0].bumper == kobuki::kBumperCentre);

  SimBuilding near(world_of("floor 0 0 0 20 20 0.1\nbox 2 0 0 0.2 4 2\n"), options_for({{1.2, 0, 0}}));
  drive(near, 0, 0.1, 0);
  for (int i = 0; i < 80; ++i) {
    near.render(0, frame);
    near.advance_to((i + 1) * kSecond / 10);
  }
  CHECK(near.record(0).contacts == 1);
  CHECK(near.record(0).contacts_measurable == 0);
  drive(near, 0, -0.1, 0);
  near.advance_to(10 * kSecond);
  drive(near, 0, 0.1, 0);
  near.advance_to(20 * kSecond);
  CHECK(near.record(0).contacts == 2);
}

TEST_CASE("two robots do not pass through each other, and nobody walks into one") {
  SimBuilding building(world_of("floor 0 0 0 40 40 0.1\nperson 1.8 0.2  0,0,3 6,0,-3 12,0,3\n"),
                       options_for({{-1, 0, 0}, {1, 0, 3.14159265358979}}));
  drive(building, 0, 0.3, 0);
  drive(building, 1, 0.3, 0);
  double nearest_person_m = 1e9;
  for (int i = 0; i < 600; ++i) {
    building.advance_to((i + 1) * kSecond / 20);
    const auto person = building.mover_places_m()[0];
    for (std::size_t robot = 0; robot < 2; ++robot) {
      const PlanarPose at = building.T_world_base(robot);
      nearest_person_m = std::min(nearest_person_m, std::hypot(double{person[0]} - at.x_m, double{person[1]} - at.y_m));
    }
  }
  CHECK(building.T_world_base(1).x_m - building.T_world_base(0).x_m == Approx(2 * 0.178).margin(0.002));
  CHECK(building.record(0).contacts_moving == 1);
  CHECK(nearest_person_m > 0.2 + 0.178 + 0.3);
}

TEST_CASE("who runs into a robot that stands is told apart from whom it drives against") {
  SimBuilding building(world_of("floor 0 0 0 40 40 0.1\nbox 0 3 0  0.2 0.4 1\n"),
                       options_for({{-1, 0, 0}, {1, 0, 0}, {-1, 3, 0}}));
  drive(building, 0, 0.3, 0);
  drive(building, 2, 0.3, 0);
  building.advance_to(15 * kSecond);
  CHECK(building.record(0).contacts_moving == 1);
  CHECK(building.record(0).contacts_ran_into == 0);
  CHECK(building.record(1).contacts_moving == 1);
  CHECK(building.record(1).contacts_ran_into == 1);
  REQUIRE(building.record(1).events.size() == 1);
  CHECK(building.record(1).events[0].ran_into);
  CHECK(building.record(1).contacts == 1);
  CHECK(building.record(2).contacts == 1);  // a box
  CHECK(building.record(2).contacts_ran_into == 0);
}

TEST_CASE("a robot that drives over an edge hangs there and it is counted") {
  SimBuilding building(world_of("floor 0 0 0 2 2 0.1\n"), options_for({{0, 0, 0}}));
  drive(building, 0, 0.2, 0);
  building.advance_to(10 * kSecond);
  CHECK(building.record(0).cliffs == 1);
  CHECK(building.record(0).wheel_drops == 1);
  CHECK(building.T_world_base(0).x_m == Approx(1.0).margin(0.01));
  drive(building, 0, 0, 0);
  building.advance_to(11 * kSecond);
  building.place(0, {0, 0, 1});
  drive(building, 0, 0.1, 0);
  building.advance_to(13 * kSecond);
  CHECK(building.T_world_base(0).x_m > 0.05);
  CHECK(building.body(0).sense().wheel_drop == 0);
}

TEST_CASE("drift comes by its scale and seed") {
  SimRobotOptions exact;
  add_drift(exact, 0.0, 3);
  CHECK(exact.base.gyro_bias_radps == 0.0);
  CHECK(exact.base.left_scale == 1.0);
  CHECK(exact.body.slip == 0.0);
  SimRobotOptions a;
  SimRobotOptions b;
  SimRobotOptions c;
  add_drift(a, 1.0, 3);
  add_drift(b, 1.0, 3);
  add_drift(c, 1.0, 4);
  CHECK(a.base.gyro_bias_radps == b.base.gyro_bias_radps);
  CHECK(a.base.gyro_bias_radps != c.base.gyro_bias_radps);
  CHECK(std::abs(a.base.left_scale - 1.0) < 0.02);
  CHECK(a.base.left_scale != a.base.right_scale);
}

TEST_CASE("rough drift is that of poses: both wheels alike, a bias, and a heading that walks") {
  SimRobotOptions none;
  add_drift(none, 0.0, 3, BaseDrift::rough);
  CHECK(none.base.gyro_noise_radps == 0.0);
  CHECK(none.base.seed == SimKobukiOptions{}.seed);
  int left_turning = 0;
  int short_wheels = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimRobotOptions robot;
    add_drift(robot, 1.0, seed, BaseDrift::rough);
    CHECK(std::abs(robot.base.gyro_bias_radps) == Approx(0.3 * std::numbers::pi / 180.0));
    CHECK(robot.base.left_scale == robot.base.right_scale);
    CHECK(std::abs(robot.base.left_scale - 1.0) == Approx(0.02));
    CHECK(robot.base.gyro_noise_radps == Approx(10.0 * 0.5 * std::numbers::pi / 180.0));
    left_turning += robot.base.gyro_bias_radps > 0.0 ? 1 : 0;
    short_wheels += robot.base.left_scale < 1.0 ? 1 : 0;
  }
  CHECK((left_turning > 3 && left_turning < 17));
  CHECK((short_wheels > 3 && short_wheels < 17));
}

TEST_CASE("the scaled Kinect shows what the whole one shows") {
  const CameraModel small = scaled_kinect(160, 120);
  const CameraModel full = scaled_kinect(640, 480);
  CHECK(full.fx_px == 525.0F);
  CHECK(full.cx_px == 319.5F);
  CHECK(small.fx_px == 131.25F);
  CHECK(80.0F / small.fx_px == Approx(320.0F / full.fx_px));
}

TEST_CASE("planned faults come and go with the building's time") {
  SimBuildingOptions options;
  options.camera = scaled_kinect(32, 24);
  options.robots.resize(1);
  options.faults = {parse_fault("line:stuck@1+1").value(), parse_fault("camera:off@1+1").value()};
  World world;
  world.add_floor({0.0, 0.0, 0.0}, 20.0, 20.0, 0.1, {});
  SimBuilding building(std::move(world), options);
  Frame frame = make_frame(options.camera);
  std::array<std::uint8_t, 512> bytes;
  for (int tenth = 1; tenth <= 30; ++tenth) {
    const TimeNs now_ns = tenth * TimeNs{100'000'000};
    building.advance_to(now_ns);
    std::size_t heard = 0;
    while (const std::size_t count = building.line(0).read(bytes)) heard += count;
    building.render(0, frame);
    INFO(tenth);
    const bool is_bad = tenth >= 10 && tenth < 20;
    CHECK(building.pass_on(0, frame, now_ns) == !is_bad);
    CHECK((heard > 0) == !(tenth > 10 && tenth < 20));  // the first packets of the tenth second still came
  }
}
