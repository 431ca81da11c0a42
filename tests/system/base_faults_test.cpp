// SPDX-License-Identifier: Apache-2.0
// The base's half of the fault matrix: what can go wrong with its line, its odometry and with those that command it and
// see for it, while it drives a circle in a simulated hall. In every case it stands within the deadline, and goes on by
// itself once the fault is over, where that is safe.
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "hal/kobuki/base_driver.hpp"
#include "hal/sim/sim_building.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kStep_ns = 20 * kMs;
constexpr TimeNs kFault_ns = 6'000 * kMs, kRepair_ns = 9'000 * kMs, kEnd_ns = 14'000 * kMs;

World hall() {
  World world;
  world.add_floor({0.0, 0.0, 0.0}, 20.0, 20.0, 0.1, {});
  return world;
}

struct Rig {
  SimBuilding building{hall(), [] {
                         SimBuildingOptions options;
                         options.camera = scaled_kinect(64, 48);
                         options.robots.resize(1);
                         return options;
                       }()};
  BaseDriver driver;
  bool line_was_up = true;
  bool commander = true, camera = true;
  TimeNs camera_delay_ns = 0, command_delay_ns = 0;
  Twist wish{0.3, 0.5};

  TimeNs now() const { return building.now(); }
  SimKobuki& kobuki() { return building.kobuki(0); }
  double true_speed() const {
    const Twist v = building.body(0).velocity();
    return std::abs(v.forward_mps) + std::abs(v.turn_radps) * kWheelBase_m / 2;
  }
  bool wants_to_stand() const { return driver.state().commanded == Twist{}; }

  void step() {
    building.advance_to(now() + kStep_ns);
    ByteLine& line = building.line(0);
    std::array<std::uint8_t, 512> bytes;
    while (const std::size_t count = line.read(bytes)) driver.on_bytes({bytes.data(), count}, now());
    if (line_was_up && line.state() == LineState::lost) driver.on_line_lost();
    line_was_up = line.state() == LineState::up;
    if (commander) driver.set_command(wish, now() - command_delay_ns);
    if (camera) driver.set_camera_alive(now() - camera_delay_ns);
    std::array<std::uint8_t, BaseDriver::kMaxOut_bytes> out;
    const std::size_t size = driver.tick(now(), out);
    if (size > 0) (void)line.write({out.data(), size});
  }
  void run_until(TimeNs end_ns) {
    while (now() < end_ns) step();
  }
};

struct Fault {
  std::string name;
  /// Called before every step while the fault lasts, with the time since it began.
  std::function<void(Rig&, TimeNs)> apply;
  std::function<void(Rig&)> repair;
  TimeNs stand_within_ns;  ///< after it began, the driver says zero; -1: it may drive on
  bool goes_on = true;     ///< after the repair
};

KobukiFaults fault(void (*set)(KobukiFaults&)) {
  KobukiFaults faults;
  set(faults);
  return faults;
}
void well(Rig& rig) {
  rig.kobuki().set_faults({});
  rig.kobuki().set_noise({}, {});
  rig.commander = rig.camera = true;
  rig.camera_delay_ns = rig.command_delay_ns = 0;
}
bool now_and_then(TimeNs since_ns, TimeNs on_ns, TimeNs off_ns) { return since_ns % (on_ns + off_ns) < on_ns; }

std::vector<Fault> matrix() {
  const auto silent = [](bool on) { return on ? fault([](KobukiFaults& f) { f.silent = true; }) : KobukiFaults{}; };
  LineNoise garbage, wrong, late;
  garbage.corrupt = 0.5;
  wrong.corrupt = 0.001;
  late.latency_ns = 150 * kMs;
  return {
      {"line off", [](Rig& r, TimeNs) { r.kobuki().set_faults(fault([](KobukiFaults& f) { f.unplugged = true; })); },
       well, 60 * kMs},
      {"line stuck", [silent](Rig& r, TimeNs) { r.kobuki().set_faults(silent(true)); }, well, 60 * kMs},
      {"line garbage", [garbage](Rig& r, TimeNs) { r.kobuki().set_noise(garbage, {}); }, well, 100 * kMs},
      {"line wrong now and then", [wrong](Rig& r, TimeNs) { r.kobuki().set_noise(wrong, {}); }, well, -1},
      {"line slow", [silent](Rig& r, TimeNs t) { r.kobuki().set_faults(silent(t % (100 * kMs) != 80 * kMs)); }, well,
       60 * kMs},
      {"line delayed", [late](Rig& r, TimeNs) { r.kobuki().set_noise(late, {}); }, well, 200 * kMs},
      {"line intermittent",
       [silent](Rig& r, TimeNs t) { r.kobuki().set_faults(silent(now_and_then(t, 200 * kMs, 60 * kMs))); }, well,
       60 * kMs},
      {"commands lost", [](Rig& r, TimeNs) { r.kobuki().set_faults(fault([](KobukiFaults& f) { f.deaf = true; })); },
       well, -1},
      {"odometry: both encoders stuck",
       [](Rig& r, TimeNs) { r.kobuki().set_faults(fault([](KobukiFaults& f) { f.left_dead = f.right_dead = true; })); },
       well, 700 * kMs},
      // Only its ticks can prove it well, and without odometry it may not try: somebody must push it.
      {"odometry: left encoder dead",
       [](Rig& r, TimeNs) { r.kobuki().set_faults(fault([](KobukiFaults& f) { f.left_dead = true; })); }, well,
       1'000 * kMs, false},
      {"odometry: right encoder dead",
       [](Rig& r, TimeNs) { r.kobuki().set_faults(fault([](KobukiFaults& f) { f.right_dead = true; })); }, well,
       1'000 * kMs, false},
      {"camera off", [](Rig& r, TimeNs) { r.camera = false; }, well, 380 * kMs},
      {"camera slow", [](Rig& r, TimeNs t) { r.camera = t % (500 * kMs) == 480 * kMs; }, well, 380 * kMs},
      {"camera delayed", [](Rig& r, TimeNs) { r.camera_delay_ns = 400 * kMs; }, well, 380 * kMs},
      {"camera intermittent", [](Rig& r, TimeNs t) { r.camera = !now_and_then(t, 800 * kMs, 200 * kMs); }, well,
       380 * kMs},
      {"navigator off", [](Rig& r, TimeNs) { r.commander = false; }, well, 200 * kMs},
      {"navigator slow", [](Rig& r, TimeNs t) { r.commander = t % (300 * kMs) == 280 * kMs; }, well, 200 * kMs},
      {"navigator delayed", [](Rig& r, TimeNs) { r.command_delay_ns = 300 * kMs; }, well, 200 * kMs},
      {"navigator wrong",
       [](Rig& r, TimeNs) {
         r.wish = {0.0 / 0.0, 1e300};
       },
       [](Rig& r) {
         well(r);
         r.wish = {0.3, 0.5};
       },
       40 * kMs},
      {"e-stop", [](Rig& r, TimeNs) { r.driver.set_e_stop(true); },
       [](Rig& r) {
         well(r);
         r.driver.set_e_stop(false);
       },
       40 * kMs, false},
  };
}

}  // namespace

TEST_CASE("Whatever fails at the base, it stands in time and goes on where that is safe") {
  for (const Fault& f : matrix()) {
    INFO(f.name);
    Rig rig;
    rig.run_until(kFault_ns);
    REQUIRE(rig.true_speed() > 0.25);

    TimeNs stood_ns = -1;
    double farthest_mps = 0.0;
    while (rig.now() < kRepair_ns) {
      f.apply(rig, rig.now() - kFault_ns);
      rig.step();
      if (stood_ns < 0 && rig.wants_to_stand()) stood_ns = rig.now() - kFault_ns;
      farthest_mps = std::max(farthest_mps, rig.driver.state().commanded.forward_mps);
    }
    if (f.stand_within_ns >= 0) {
      CHECK(stood_ns >= 0);
      CHECK(stood_ns <= f.stand_within_ns);
    }
    CHECK(farthest_mps <= 0.3 + 1e-9);

    f.repair(rig);
    rig.run_until(kEnd_ns);
    if (f.goes_on) {
      CHECK(rig.true_speed() > 0.25);
    } else {
      CHECK(rig.true_speed() == Approx(0.0).margin(1e-3));
    }
  }
}

TEST_CASE("A base that was unplugged in full motion is stopped before it may drive again") {
  Rig rig;
  rig.run_until(kFault_ns);
  rig.kobuki().set_faults(fault([](KobukiFaults& f) { f.unplugged = true; }));
  rig.run_until(kRepair_ns);
  CHECK(rig.true_speed() > 0.25);  // nobody can tell it: it keeps its last command
  well(rig);
  rig.run_until(kRepair_ns + 60 * kMs);
  CHECK(rig.kobuki().drive() == BaseControl{});
  CHECK(rig.driver.state().conditions.has(Condition::silent_base));
}

TEST_CASE("Line noise costs packets, not odometry") {
  Rig rig;
  LineNoise noise;
  noise.corrupt = 0.001;
  noise.lose = 0.0005;
  rig.kobuki().set_noise(noise, noise);
  const PlanarPose start = rig.building.T_world_base(0);
  rig.run_until(60'000 * kMs);
  const PlanarPose truth = rig.building.T_world_base(0), odometry = rig.driver.state().T_world_base;
  CHECK(rig.driver.state().rejects.total() > 50);
  CHECK(odometry.x_m == Approx(truth.x_m - start.x_m).margin(0.05));
  CHECK(odometry.y_m == Approx(truth.y_m - start.y_m).margin(0.05));
  CHECK(rig.building.body(0).driven_m() > 5.0);
}
