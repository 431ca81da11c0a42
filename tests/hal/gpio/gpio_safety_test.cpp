// SPDX-License-Identifier: Apache-2.0
#include "hal/gpio/gpio_safety.hpp"

#include <catch2/catch.hpp>

#include "hal/gpio/status_lamp.hpp"
#include "hal/replay/gpio_log.hpp"
#include "hal/replay/text_recorder.hpp"
#include "tests/support/scripted_gpio.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

constexpr TimeNs kMsS = 1'000'000;

GpioSafetyOptions one_switch() {
  GpioSafetyOptions options;
  options.names = {"estop", ""};
  return options;
}

}  // namespace

TEST_CASE("The switch's word is the lines' word", "[gpio]") {
  test::ScriptedGpio lines;
  GpioSafety safety(lines, one_switch());
  CHECK(safety.look(0) == StopWord::not_yet);
  CHECK(safety.look(50 * kMsS) == StopWord::go);
  lines.set(false, 60 * kMsS);
  CHECK(safety.look(62 * kMsS) == StopWord::stop);
  lines.set(true, 70 * kMsS);
  CHECK(safety.look(72 * kMsS) == StopWord::stop);
  CHECK(safety.look(130 * kMsS) == StopWord::go);
  lines.set_unreadable(true);
  CHECK(safety.look(132 * kMsS) == StopWord::stop);
  CHECK(safety.estop().fault() == EstopFault::unreadable);
}

TEST_CASE("Without a switch the lines say nothing", "[gpio]") {
  test::ScriptedGpio lines(1, false);
  GpioSafetyOptions options = one_switch();
  options.has_estop = false;
  GpioSafety safety(lines, options);
  CHECK(safety.look(0) == StopWord::go);
  CHECK(safety.look(100 * kMsS) == StopWord::go);
}

TEST_CASE("The lamp says in which state the robot is", "[gpio]") {
  test::ScriptedGpio lines;
  GpioSafety safety(lines, one_switch());
  SafetyNews news;
  const auto flashes_in_a_second = [&] {
    int flashes = 0;
    bool was_lit = lamp_is_lit(news, 0);
    for (TimeNs t_ns = 0; t_ns < 1'000 * kMsS; t_ns += kMsS) {
      safety.show(news, t_ns);
      REQUIRE(lines.output() == (lamp_is_lit(news, t_ns) ? 1 : 0));
      flashes += lines.output() == 1 && !was_lit;
      was_lit = lines.output() == 1;
    }
    return flashes;
  };
  CHECK(flashes_in_a_second() == 0);  // one second is one slow period: lit, dark
  CHECK_FALSE(lamp_is_lit(news, 600 * kMsS));
  news.conditions.set(Condition::e_stop);
  CHECK(flashes_in_a_second() == 3);
  news.conditions = {};
  news.state = SafetyState::free;
  CHECK(flashes_in_a_second() == 0);
  CHECK(lines.output() == 1);
  safety.say_farewell(0);
  CHECK(lines.output() == 0);
}

TEST_CASE("Edges are recorded in the order of time, and say the same again", "[gpio][threads]") {
  const test::TempFolder folder;
  auto recorder = TextRecorder::create(folder / "gpio.log");
  REQUIRE(recorder.ok());
  test::ScriptedGpio lines;
  GpioSafety safety(lines, one_switch(), recorder.value().get());
  std::vector<StopWord> live;
  live.push_back(safety.look(10 * kMsS));
  live.push_back(safety.look(60 * kMsS));
  lines.set(false, 61 * kMsS);
  live.push_back(safety.look(62 * kMsS));
  lines.set(true, 63 * kMsS);
  live.push_back(safety.look(64 * kMsS));
  live.push_back(safety.look(120 * kMsS));
  REQUIRE(recorder.value()->finish().ok());
  CHECK(test::read_plain(folder / "gpio.log") == "10000000 estop 1\n61000000 estop 0\n63000000 estop 1\n");

  const auto log = read_gpio_log(folder / "gpio.log");
  REQUIRE(log.ok());
  DataClock clock;
  ReplayedGpio replayed(log.value(), clock, {"estop", ""});
  GpioSafety again(replayed, one_switch());
  const std::array<TimeNs, 5> looks{10, 60, 62, 64, 120};
  for (std::size_t i = 0; i < looks.size(); ++i) {
    clock.advance_to(looks[i] * kMsS);
    CHECK(again.look(looks[i] * kMsS) == live[i]);
  }
}
