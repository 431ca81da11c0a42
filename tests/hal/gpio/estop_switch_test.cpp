// SPDX-License-Identifier: Apache-2.0
#include "hal/gpio/estop_switch.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

namespace {

constexpr TimeNs kMsG = 1'000'000;

struct SwitchBench {
  explicit SwitchBench(const EstopSwitchOptions& options = {}) : contact(options) {}
  StopWord at(TimeNs ms) {
    now_ns = ms * kMsG;
    return contact.word(now_ns);
  }
  void edge_us(TimeNs us, bool level, std::uint8_t line = 0) { contact.on_edge({us * 1'000, line, level}); }
  void level(bool high, std::size_t line = 0) { contact.on_level(line, high, now_ns); }
  /// Released, and seen to be.
  void release() {
    level(true);
    REQUIRE(at(0) == StopWord::not_yet);
    REQUIRE(at(50) == StopWord::go);
  }
  EstopSwitch contact;
  TimeNs now_ns = 0;
};

}  // namespace

TEST_CASE("A switch is awaited until it was closed for a while", "[gpio]") {
  SwitchBench bench;
  CHECK(bench.at(0) == StopWord::not_yet);
  bench.level(true);
  CHECK(bench.at(49) == StopWord::not_yet);
  CHECK(bench.at(50) == StopWord::go);
  CHECK(bench.contact.presses() == 0);
}

TEST_CASE("Pressed at the start it is a stop", "[gpio]") {
  SwitchBench bench;
  bench.level(false);
  CHECK(bench.at(0) == StopWord::not_yet);
  CHECK(bench.at(2) == StopWord::stop);
}

TEST_CASE("An opening is a stop at the next look, a disturbance is none", "[gpio]") {
  SwitchBench bench;
  bench.release();
  bench.edge_us(100'000, false);
  bench.edge_us(100'900, true);  // 0.9 ms
  CHECK(bench.at(102) == StopWord::go);
  CHECK(bench.contact.glitches() == 1);
  bench.edge_us(110'000, false);
  bench.edge_us(111'100, true);  // 1.1 ms, all of it between two looks
  CHECK(bench.at(112) == StopWord::stop);
  CHECK(bench.contact.presses() == 1);
  CHECK(bench.at(200) == StopWord::go);
  bench.edge_us(300'000, false);
  CHECK(bench.at(300) == StopWord::go);  // not yet longer than a disturbance
  CHECK(bench.at(301) == StopWord::stop);
  CHECK(bench.contact.presses() == 2);
}

TEST_CASE("Bouncing contacts press once and release once", "[gpio]") {
  SwitchBench bench;
  bench.release();
  bench.edge_us(100'000, false);
  CHECK(bench.at(102) == StopWord::stop);
  for (int i = 0; i < 10; ++i) {  // it bounces while it closes again
    bench.edge_us(200'000 + i * 4'000, true);
    bench.edge_us(202'000 + i * 4'000, false);
    CHECK(bench.at(203 + i * 4) == StopWord::stop);
  }
  bench.edge_us(240'000, true);
  CHECK(bench.at(289) == StopWord::stop);
  CHECK(bench.at(290) == StopWord::go);
  CHECK(bench.contact.presses() == 1);
}

TEST_CASE("A broken wire, a lost edge and a lost chip are stops", "[gpio]") {
  SwitchBench broken;
  broken.release();
  broken.at(100);
  broken.level(false);  // no edge ever came
  CHECK(broken.at(102) == StopWord::stop);

  SwitchBench gone;
  gone.release();
  gone.contact.on_unreadable(0, gone.now_ns);
  CHECK(gone.at(50) == StopWord::stop);  // at once: that is no disturbance
  CHECK(gone.contact.fault() == EstopFault::unreadable);
  gone.level(true);
  CHECK(gone.at(60) == StopWord::stop);
  CHECK(gone.at(120) == StopWord::go);
  CHECK(gone.contact.fault() == EstopFault::none);
}

TEST_CASE("Closed may be the low level", "[gpio]") {
  EstopSwitchOptions options;
  options.closed_level = false;
  SwitchBench bench(options);
  bench.level(false);
  (void)bench.at(0);
  CHECK(bench.at(50) == StopWord::go);
  bench.edge_us(60'000, true);
  CHECK(bench.at(62) == StopWord::stop);
}

TEST_CASE("Two contacts must agree", "[gpio]") {
  EstopSwitchOptions options;
  options.lines = 2;
  SwitchBench bench(options);
  bench.level(true, 0);
  bench.level(false, 1);  // normally open: low while not pressed
  (void)bench.at(0);
  CHECK(bench.at(50) == StopWord::go);
  // Either of them alone stops.
  bench.edge_us(60'000, true, 1);
  CHECK(bench.at(62) == StopWord::stop);
  CHECK(bench.contact.fault() == EstopFault::none);
  CHECK(bench.at(100) == StopWord::stop);
  CHECK(bench.contact.fault() == EstopFault::none);
  CHECK(bench.at(170) == StopWord::stop);
  CHECK(bench.contact.fault() == EstopFault::discrepancy);  // the wires of both touch
  bench.edge_us(180'000, false, 1);
  CHECK(bench.at(182) == StopWord::stop);
  CHECK(bench.at(230) == StopWord::go);
  CHECK(bench.contact.fault() == EstopFault::none);
  bench.edge_us(300'000, false, 0);
  bench.edge_us(310'000, true, 1);
  CHECK(bench.at(312) == StopWord::stop);
  CHECK(bench.at(500) == StopWord::stop);
  CHECK(bench.contact.fault() == EstopFault::none);  // pressed, and both say so
  // Edges of lines that there are not are nothing.
  bench.contact.on_edge({0, 7, true});
  bench.contact.on_level(2, true, 0);
}
