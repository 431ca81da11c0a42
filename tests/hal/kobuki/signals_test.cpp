// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/signals.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

struct Bench {
  Signals signals;
  TimeNs now_ns = 0;

  Signal after(TimeNs pause_ns, std::initializer_list<Condition> wrong) {
    now_ns += pause_ns;
    Conditions conditions;
    for (const Condition c : wrong) conditions.set(c);
    return signals.update(judge(conditions), conditions, now_ns);
  }
};

}  // namespace

TEST_CASE("LEDs say what the base may do and how its battery is") {
  struct Row {
    Condition condition;
    LedColour state, battery;
  };
  for (const Row& row : {Row{Condition::rear_unknown, LedColour::green, LedColour::green},
                         Row{Condition::bumper, LedColour::orange, LedColour::green},
                         Row{Condition::cliff, LedColour::orange, LedColour::green},
                         Row{Condition::e_stop, LedColour::red, LedColour::green},
                         Row{Condition::silent_base, LedColour::red, LedColour::green},
                         Row{Condition::battery_low, LedColour::orange, LedColour::orange},
                         Row{Condition::battery_empty, LedColour::red, LedColour::red}}) {
    INFO(to_string(row.condition));
    Bench bench;
    const Signal signal = bench.after(0, {row.condition});
    CHECK(signal.state == row.state);
    CHECK(signal.battery == row.battery);
  }
}

TEST_CASE("Ready is heard once, and nothing before") {
  Bench bench;
  CHECK_FALSE(bench.after(0, {Condition::silent_base, Condition::silent_camera}).sound);
  CHECK_FALSE(bench.after(kSecond_ns, {Condition::silent_camera}).sound);
  CHECK(bench.after(kSecond_ns, {}).sound == SoundSequence::on);
  CHECK_FALSE(bench.after(2 * kSecond_ns, {}).sound);
}

TEST_CASE("What begins is heard once, what goes on is not") {
  for (const Condition c : {Condition::e_stop, Condition::wheel_drop, Condition::cliff, Condition::over_current,
                            Condition::dead_wheel, Condition::battery_empty, Condition::silent_camera}) {
    INFO(to_string(c));
    Bench bench;
    (void)bench.after(0, {});
    CHECK(bench.after(2 * kSecond_ns, {c}).sound == SoundSequence::error);
    CHECK_FALSE(bench.after(2 * kSecond_ns, {c}).sound);
  }
  Bench bench;
  (void)bench.after(0, {});
  CHECK(bench.after(2 * kSecond_ns, {Condition::battery_low}).sound == SoundSequence::recharge);
  CHECK_FALSE(bench.after(2 * kSecond_ns, {Condition::battery_low, Condition::stale_command}).sound);
}

TEST_CASE("Resumed after an e-stop is heard") {
  Bench bench;
  (void)bench.after(0, {});
  CHECK(bench.after(2 * kSecond_ns, {Condition::e_stop}).sound == SoundSequence::error);
  CHECK(bench.after(2 * kSecond_ns, {}).sound == SoundSequence::button);
}

TEST_CASE("No more than one sound in a second; what still holds then is told") {
  Bench bench;
  CHECK(bench.after(0, {}).sound == SoundSequence::on);
  CHECK_FALSE(bench.after(kSecond_ns / 2, {Condition::cliff}).sound);
  CHECK(bench.after(kSecond_ns / 2, {Condition::cliff}).sound == SoundSequence::error);
  int heard = 0;
  for (int i = 0; i < 100; ++i) {  // five seconds of a flickering sensor
    heard += bench.after(kSecond_ns / 20, {}).sound.has_value();
    heard += bench.after(0, {Condition::cliff}).sound.has_value();
  }
  CHECK(heard >= 4);
  CHECK(heard <= 5);
}
