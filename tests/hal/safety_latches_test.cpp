// SPDX-License-Identifier: Apache-2.0
#include "hal/safety_latches.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kPeriod_ns = 20 * kMs;

// A base, a commander and a camera that all are well, until a test says otherwise.
struct Bench {
  SafetyTimes times;
  SafetyLatches latches;
  TimeNs now_ns = 0;
  bool base = true, command = true, camera = true, thread = true;

  void step(const PacketFlags& flags = {}) {
    now_ns += kPeriod_ns;
    if (base) note_packet(latches, flags, now_ns, times);
    if (command) note_command(latches, now_ns);
    if (camera) note_image(latches, now_ns);
    if (thread) note_tick(latches, now_ns, times);
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) step();
  }
  Conditions now() const { return conditions_at(latches, now_ns, times); }
  bool has(Condition c) const { return now().has(c); }
};

Bench running() {
  Bench bench;
  bench.latches.rear_free = true;
  bench.steps(10);
  REQUIRE(bench.now().none());
  return bench;
}

}  // namespace

TEST_CASE("At the start nothing has proved to be alive") {
  const Conditions c = conditions_at({}, 0, {});
  CHECK(c.has(Condition::silent_base));
  CHECK(c.has(Condition::silent_camera));
  CHECK(c.has(Condition::stale_command));
  CHECK(c.has(Condition::late_thread));
  CHECK(c.has(Condition::rear_unknown));
  CHECK_FALSE(c.has(Condition::e_stop));
  CHECK_FALSE(c.has(Condition::bumper));
  CHECK(judge(c).state == SafetyState::stand);
}

TEST_CASE("A base is believed after five packets in a row") {
  Bench bench;
  bench.steps(4);
  CHECK(bench.has(Condition::silent_base));
  bench.steps(1);
  CHECK_FALSE(bench.has(Condition::silent_base));
}

TEST_CASE("Flags hold from the first packet until five agree") {
  struct Flag {
    PacketFlags flags;
    Condition condition;
  };
  PacketFlags bumper, cliff, firmware;
  bumper.bumper = cliff.cliff = firmware.wrong_firmware = true;
  for (const Flag& flag :
       {Flag{bumper, Condition::bumper}, Flag{cliff, Condition::cliff}, Flag{firmware, Condition::wrong_firmware}}) {
    INFO(to_string(flag.condition));
    Bench bench = running();
    bench.step(flag.flags);
    CHECK(bench.has(flag.condition));
    bench.steps(4);
    CHECK(bench.has(flag.condition));
    bench.step(flag.flags);  // begins again
    bench.steps(4);
    CHECK(bench.has(flag.condition));
    bench.steps(1);
    CHECK(bench.now().none());
  }
}

TEST_CASE("One packet in between clears nothing, however often it comes") {
  Bench bench = running();
  PacketFlags pressed;
  pressed.bumper = pressed.wheel_drop = pressed.cliff = true;
  for (int i = 0; i < 200; ++i) {
    bench.step(i % 5 == 0 ? pressed : PacketFlags{});
    REQUIRE(bench.has(Condition::bumper));
    REQUIRE(bench.has(Condition::cliff));
    REQUIRE(bench.has(Condition::wheel_drop));
  }
}

TEST_CASE("A dropped wheel is forgotten when both were up for one second of packets") {
  Bench bench = running();
  PacketFlags dropped;
  dropped.wheel_drop = true;
  bench.step(dropped);
  bench.steps(49);
  CHECK(bench.has(Condition::wheel_drop));
  bench.steps(1);
  CHECK_FALSE(bench.has(Condition::wheel_drop));

  bench.step(dropped);
  bench.steps(40);
  bench.step(dropped);
  bench.steps(49);
  CHECK(bench.has(Condition::wheel_drop));
}

TEST_CASE("Silence does not count as time with both wheels up") {
  Bench bench = running();
  PacketFlags dropped;
  dropped.wheel_drop = true;
  bench.step(dropped);
  bench.base = false;
  bench.steps(100);
  CHECK(bench.has(Condition::wheel_drop));
  bench.base = true;
  bench.steps(50);
  CHECK(bench.has(Condition::wheel_drop));
  bench.steps(1);
  CHECK(bench.now().none());
}

TEST_CASE("Over-current stands for half a second after it, a dead wheel for one") {
  for (const bool dead : {false, true}) {
    const Condition condition = dead ? Condition::dead_wheel : Condition::over_current;
    Bench bench = running();
    PacketFlags flags;
    (dead ? flags.dead_wheel : flags.over_current) = true;
    bench.step(flags);
    bench.steps(dead ? 49 : 24);
    CHECK(bench.has(condition));
    bench.steps(1);
    CHECK(bench.now().none());
  }
}

TEST_CASE("A dead wheel is tried less and less often, until both have rolled") {
  Bench bench = running();
  PacketFlags dead, rolling;
  dead.dead_wheel = true;
  rolling.wheels_count = true;
  for (const int wait : {50, 100, 200, 400, 800, 1600, 1600}) {
    bench.step(dead);
    bench.steps(wait - 1);
    CHECK(bench.has(Condition::dead_wheel));
    bench.steps(1);
    CHECK(bench.now().none());
  }
  bench.step(rolling);
  bench.step(dead);
  bench.steps(49);
  CHECK(bench.has(Condition::dead_wheel));
  bench.steps(1);
  CHECK(bench.now().none());
}

TEST_CASE("The battery must agree for a second") {
  for (const bool empty : {false, true}) {
    const Condition condition = empty ? Condition::battery_empty : Condition::battery_low;
    Bench bench = running();
    PacketFlags flags;
    (empty ? flags.battery_empty : flags.battery_low) = true;
    bench.step(flags);
    CHECK(bench.has(condition));
    bench.steps(49);
    CHECK(bench.has(condition));
    bench.steps(1);
    CHECK(bench.now().none());
  }
}

TEST_CASE("A silent base is seen after 45 ms, and believed again after five packets") {
  Bench bench = running();
  const SafetyLatches& l = bench.latches;
  CHECK_FALSE(conditions_at(l, bench.now_ns + 45 * kMs, bench.times).has(Condition::silent_base));
  CHECK(conditions_at(l, bench.now_ns + 45 * kMs + 1, bench.times).has(Condition::silent_base));
  bench.base = false;
  bench.steps(3);
  CHECK(bench.has(Condition::silent_base));
  bench.base = true;
  bench.steps(4);
  CHECK(bench.has(Condition::silent_base));
  bench.steps(1);
  CHECK(bench.now().none());
}

TEST_CASE("A lost packet alone is not a silence") {
  Bench bench = running();
  bench.base = false;
  bench.step();
  bench.base = true;
  bench.step();
  CHECK(bench.now().none());
}

TEST_CASE("A slow base, one packet in 100 ms, stays silent") {
  Bench bench = running();
  for (int i = 0; i < 100; ++i) {
    bench.base = i % 5 == 4;
    bench.step();
    if (i >= 2) REQUIRE(bench.has(Condition::silent_base));
  }
}

TEST_CASE("Old feedback is late, and five fresh ones make it good") {
  Bench bench = running();
  PacketFlags old;
  old.age_ns = 80 * kMs;
  bench.step(old);
  CHECK(bench.now().none());
  old.age_ns = 80 * kMs + 1;
  bench.step(old);
  CHECK(bench.has(Condition::late_base));
  bench.steps(4);
  CHECK(bench.has(Condition::late_base));
  bench.steps(1);
  CHECK(bench.now().none());
}

TEST_CASE("Commands and images go stale, each by its own limit, and the next one makes them good") {
  Bench bench = running();
  bench.command = false;
  bench.steps(8);
  CHECK_FALSE(bench.has(Condition::stale_command));
  bench.steps(1);
  CHECK(bench.has(Condition::stale_command));
  CHECK_FALSE(bench.has(Condition::silent_camera));
  bench.command = true;
  bench.camera = false;
  bench.steps(17);
  CHECK(bench.now().none());
  bench.steps(1);
  CHECK(bench.has(Condition::silent_camera));
  bench.camera = true;
  bench.step();
  CHECK(bench.now().none());
}

TEST_CASE("An older stamp than the last, or one from another clock, proves nothing") {
  Bench bench = running();
  const TimeNs t = bench.now_ns;
  note_command(bench.latches, t - 100 * kMs);
  CHECK_FALSE(conditions_at(bench.latches, t + 160 * kMs, bench.times).has(Condition::stale_command));
  note_command(bench.latches, t + 3600'000 * kMs);
  CHECK(conditions_at(bench.latches, t, bench.times).has(Condition::stale_command));
  note_image(bench.latches, t + 10 * kMs);  // a little ahead is a race between two threads
  CHECK_FALSE(conditions_at(bench.latches, t, bench.times).has(Condition::silent_camera));
}

TEST_CASE("A late tick stands for the next five") {
  Bench bench = running();
  bench.now_ns += 200 * kMs;
  bench.step();
  CHECK(bench.has(Condition::late_thread));
  bench.steps(4);
  CHECK(bench.has(Condition::late_thread));
  bench.steps(1);
  CHECK(bench.now().none());
  CHECK(conditions_at(bench.latches, bench.now_ns + 60 * kMs + 1, bench.times).has(Condition::late_thread));
}

TEST_CASE("After an e-stop nothing but a person's word resumes") {
  Bench bench = running();
  note_e_stop(bench.latches, true);
  CHECK(bench.has(Condition::e_stop));
  CHECK_FALSE(resume_after_e_stop(bench.latches));
  CHECK(bench.has(Condition::e_stop));
  note_e_stop(bench.latches, false);
  bench.steps(10'000);
  CHECK(bench.has(Condition::e_stop));
  CHECK(resume_after_e_stop(bench.latches));
  CHECK(bench.now().none());
  CHECK(resume_after_e_stop(bench.latches));
}

TEST_CASE("The rear is unknown unless somebody says otherwise") {
  Bench bench = running();
  bench.latches.rear_free = false;
  CHECK(bench.has(Condition::rear_unknown));
  CHECK(judge(bench.now()).allowance.backward_mps == 0.0);
  CHECK(judge(bench.now()).state == SafetyState::free);
}

TEST_CASE("A stop device that is awaited holds the robot, and nobody needs to say resume") {
  Bench bench;
  note_e_stop_awaited(bench.latches, true);
  CHECK(bench.has(Condition::e_stop));
  CHECK(resume_after_e_stop(bench.latches));  // in vain: it is not there yet
  CHECK(bench.has(Condition::e_stop));
  note_e_stop_awaited(bench.latches, false);
  CHECK_FALSE(bench.has(Condition::e_stop));
}

TEST_CASE("Everything at once, and each goes its own way") {
  Bench bench = running();
  PacketFlags all{true, true, true, true, true, true, true, false, true, 1000 * kMs};
  note_e_stop(bench.latches, true);
  bench.step(all);
  bench.base = bench.command = bench.camera = bench.thread = false;
  bench.latches.rear_free = false;
  bench.now_ns += 400 * kMs;
  Conditions every;
  every.bits = (1U << kConditionCount) - 1;
  CHECK(bench.now() == every);
  CHECK(judge(bench.now()).reason == Condition::e_stop);
  bench.base = bench.command = bench.camera = bench.thread = true;
  bench.latches.rear_free = true;
  bench.steps(60);
  Conditions left;
  left.set(Condition::e_stop);
  CHECK(bench.now() == left);
}
