// SPDX-License-Identifier: Apache-2.0
#include "hal/can/can_safety.hpp"

#include <catch2/catch.hpp>

#include "hal/replay/can_log.hpp"
#include "hal/replay/text_recorder.hpp"
#include "tests/support/scripted_can.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::hal::can;

namespace {

constexpr TimeNs kMsC = 1'000'000;

CanSafetyOptions robot_with_node_17() {
  CanSafetyOptions options;
  options.own_node = 10;
  options.estop = {17, 500 * kMsC};
  return options;
}

struct CanBench {
  explicit CanBench(const CanSafetyOptions& options = robot_with_node_17(), TextRecorder* recorder = nullptr)
      : safety(port, options, recorder) {}
  StopWord pass(TimeNs ms) {
    now_ns += ms * kMsC;
    const StopWord word = safety.look(now_ns);
    safety.show(news, now_ns);
    return word;
  }
  void node_says(NmtState state) { port.waiting.push_back(encode(Heartbeat{17, state})); }

  test::ScriptedCan port;
  CanSafety safety;
  SafetyNews news;
  TimeNs now_ns = 0;
};

}  // namespace

TEST_CASE("On the bus we boot, go operational and say how the robot is", "[can]") {
  CanBench bench;
  bench.news.state = SafetyState::free;
  bench.news.commanded = {0.25, -0.5};
  bench.news.battery_v = 14.8;
  (void)bench.pass(2);
  REQUIRE(bench.port.written.size() == 2);
  CHECK(std::get<Heartbeat>(decode(bench.port.written[0])) == Heartbeat{10, NmtState::boot_up});
  (void)bench.pass(100);
  CHECK(std::get<Heartbeat>(decode(*bench.port.last(0x70A))) == Heartbeat{10, NmtState::operational});
  RobotStatus status;
  REQUIRE(decode_status(*bench.port.last(0x18A), status));
  CHECK(status == RobotStatus{10, static_cast<std::uint8_t>(SafetyState::free), 0, 250, -500, 148});
  const std::size_t before = bench.port.written.size();
  (void)bench.pass(50);
  CHECK(bench.port.written.size() == before);
  bench.safety.say_farewell(bench.now_ns);
  CHECK(std::get<Heartbeat>(decode(*bench.port.last(0x70A))).state == NmtState::stopped);
}

TEST_CASE("The stop node's word is the bus's word", "[can]") {
  CanBench bench;
  CHECK(bench.pass(2) == StopWord::not_yet);
  bench.node_says(NmtState::operational);
  CHECK(bench.pass(2) == StopWord::go);
  bench.port.waiting.push_back(encode(Emergency{17, 0xFF01, 1, {}}));
  CHECK(bench.pass(2) == StopWord::stop);
  bench.port.waiting.push_back(encode(Emergency{17, 0, 0, {}}));
  CHECK(bench.pass(2) == StopWord::go);
  CHECK(bench.pass(600) == StopWord::stop);
}

TEST_CASE("A waiting stop node is started by its master alone, once a second", "[can]") {
  CanBench left_alone;
  left_alone.node_says(NmtState::pre_operational);
  (void)left_alone.pass(2);
  CHECK_FALSE(left_alone.port.last(0x000));

  CanSafetyOptions options = robot_with_node_17();
  options.starts_estop = true;
  CanBench bench(options);
  bench.node_says(NmtState::pre_operational);
  CHECK(bench.pass(2) == StopWord::not_yet);
  REQUIRE(bench.port.last(0x000));
  CHECK(std::get<NmtOrder>(decode(*bench.port.last(0x000))) == NmtOrder{NmtCommand::start, 17});
  bench.node_says(NmtState::pre_operational);
  (void)bench.pass(100);
  CHECK(bench.safety.counts().starts_sent == 1);
  bench.node_says(NmtState::pre_operational);
  (void)bench.pass(1'000);
  CHECK(bench.safety.counts().starts_sent == 2);
}

TEST_CASE("A network master may stop us, and only its start ends that", "[can]") {
  for (const NmtCommand command : {NmtCommand::stop, NmtCommand::enter_pre_operational, NmtCommand::reset_node}) {
    CanSafetyOptions options = robot_with_node_17();
    options.has_estop = false;
    CanBench bench(options);
    CHECK(bench.pass(2) == StopWord::go);
    bench.port.waiting.push_back(encode(NmtOrder{command, 11}));
    CHECK(bench.pass(2) == StopWord::go);
    bench.port.waiting.push_back(
        encode(NmtOrder{command, command == NmtCommand::stop ? std::uint8_t{0} : std::uint8_t{10}}));
    CHECK(bench.pass(2) == StopWord::stop);
    CHECK(bench.pass(200) == StopWord::stop);
    CHECK(std::get<Heartbeat>(decode(*bench.port.last(0x70A))).state != NmtState::operational);
    bench.port.waiting.push_back(encode(NmtOrder{NmtCommand::start, 10}));
    CHECK(bench.pass(2) == StopWord::go);
  }
}

TEST_CASE("An order and its end between two looks is a stop", "[can]") {
  CanSafetyOptions options = robot_with_node_17();
  options.has_estop = false;
  CanBench bench(options);
  CHECK(bench.pass(2) == StopWord::go);
  bench.port.waiting.push_back(encode(NmtOrder{NmtCommand::stop, 0}));
  bench.port.waiting.push_back(encode(NmtOrder{NmtCommand::start, 0}));
  CHECK(bench.pass(2) == StopWord::stop);
  CHECK(bench.pass(2) == StopWord::go);
}

TEST_CASE("A babbling bus cannot keep the base waiting, and every frame is counted", "[can]") {
  CanBench bench;
  CanFrame noise;
  noise.id = 0x3FF;
  for (int i = 0; i < 1'000; ++i) bench.port.waiting.push_back(noise);
  bench.node_says(NmtState::operational);
  (void)bench.pass(2);
  CHECK(bench.port.waiting.size() > 800);
  int looks = 1;
  for (; !bench.port.waiting.empty(); ++looks) (void)bench.pass(0);
  CHECK(bench.safety.counts().frames == 1'001);
  CHECK(bench.safety.counts().ignored[static_cast<std::size_t>(NoMessage::other)] == 1'000);
  CHECK(bench.safety.counts().left_waiting == static_cast<std::uint64_t>(looks - 1));
  CHECK(bench.pass(1) == StopWord::go);
}

TEST_CASE("What was said on the bus is recorded, and says the same again", "[can][threads]") {
  const test::TempFolder folder;
  auto recorder = TextRecorder::create(folder / "can.log");
  REQUIRE(recorder.ok());
  CanBench bench(robot_with_node_17(), recorder.value().get());
  std::vector<StopWord> live;
  live.push_back(bench.pass(2));
  bench.node_says(NmtState::operational);
  live.push_back(bench.pass(2));
  bench.port.waiting.push_back(encode(Emergency{17, 0xFF01, 1, {}}));
  live.push_back(bench.pass(2));
  REQUIRE(recorder.value()->finish().ok());

  const auto log = read_can_log(folder / "can.log");
  REQUIRE(log.ok());
  CHECK(log.value().interface == "can0");
  DataClock clock;
  ReplayedCan port(log.value(), clock);
  CanSafety again(port, robot_with_node_17());
  for (std::size_t i = 0; i < live.size(); ++i) {
    const TimeNs t_ns = static_cast<TimeNs>(i + 1) * 2 * kMsC;
    clock.advance_to(t_ns);
    CHECK(again.look(t_ns) == live[i]);
  }
  CHECK(port.is_over());
}
