// SPDX-License-Identifier: Apache-2.0
#include "hal/can/estop_node.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::can;

namespace {

constexpr TimeNs kMsN = 1'000'000;
constexpr std::uint8_t kStopNode = 17;

struct NodeBench {
  EstopNode node{EstopNodeOptions{kStopNode, 500 * kMsN}};
  TimeNs now_ns = 1'000 * kMsN;

  StopWord beat(NmtState state = NmtState::operational) {
    node.on_message(Heartbeat{kStopNode, state}, now_ns);
    return node.word(now_ns);
  }
  StopWord emergency(std::uint16_t code, std::uint8_t error_register) {
    node.on_message(Emergency{kStopNode, code, error_register, {}}, now_ns);
    return node.word(now_ns);
  }
  StopWord after(TimeNs ms) {
    now_ns += ms * kMsN;
    return node.word(now_ns);
  }
};

}  // namespace

TEST_CASE("A stop node that was never heard is awaited, not an emergency", "[can]") {
  NodeBench bench;
  CHECK(bench.node.word(bench.now_ns) == StopWord::not_yet);
  CHECK(bench.after(10'000) == StopWord::not_yet);
  CHECK(bench.beat(NmtState::boot_up) == StopWord::not_yet);
  CHECK(bench.beat(NmtState::pre_operational) == StopWord::not_yet);
  CHECK(bench.beat() == StopWord::go);
}

TEST_CASE("A lost heartbeat is a stop, to the millisecond", "[can]") {
  NodeBench bench;
  CHECK(bench.beat() == StopWord::go);
  CHECK(bench.after(500) == StopWord::go);
  CHECK(bench.after(1) == StopWord::stop);
  CHECK(bench.node.losses() == 1);
  CHECK(bench.beat() == StopWord::stop);  // it was away: that has to be known, once
  CHECK(bench.after(1) == StopWord::go);
}

TEST_CASE("A gap between two heartbeats counts though nobody looked meanwhile", "[can]") {
  NodeBench bench;
  CHECK(bench.beat() == StopWord::go);
  bench.now_ns += 900 * kMsN;
  CHECK(bench.beat() == StopWord::stop);
  CHECK(bench.after(1) == StopWord::go);
}

TEST_CASE("An emergency stops until all of it is over", "[can]") {
  NodeBench bench;
  CHECK(bench.beat() == StopWord::go);
  CHECK(bench.emergency(0xFF01, 0x81) == StopWord::stop);
  CHECK(bench.beat() == StopWord::stop);
  CHECK(bench.emergency(0x0000, 0x80) == StopWord::stop);  // one of two
  CHECK(bench.emergency(0x0000, 0x00) == StopWord::go);
  CHECK(bench.node.emergencies() == 3);
}

TEST_CASE("An emergency that begins and ends between two looks is a stop", "[can]") {
  NodeBench bench;
  CHECK(bench.beat() == StopWord::go);
  bench.node.on_message(Emergency{kStopNode, 0xFF01, 1, {}}, bench.now_ns);
  bench.node.on_message(Emergency{kStopNode, 0, 0, {}}, bench.now_ns);
  CHECK(bench.node.word(bench.now_ns) == StopWord::stop);
  CHECK(bench.node.word(bench.now_ns) == StopWord::go);
}

TEST_CASE("An emergency stops before the first heartbeat too", "[can]") {
  NodeBench bench;
  CHECK(bench.emergency(0xFF01, 1) == StopWord::stop);
}

TEST_CASE("A node that leaves the operational state stops the robot", "[can]") {
  for (const NmtState state : {NmtState::stopped, NmtState::pre_operational, NmtState::boot_up}) {
    NodeBench bench;
    CHECK(bench.beat() == StopWord::go);
    CHECK(bench.beat(state) == StopWord::stop);
    CHECK(bench.beat() == StopWord::go);
  }
}

TEST_CASE("Other nodes say nothing about it", "[can]") {
  NodeBench bench;
  bench.node.on_message(Heartbeat{kStopNode + 1, NmtState::operational}, bench.now_ns);
  CHECK(bench.node.word(bench.now_ns) == StopWord::not_yet);
  CHECK(bench.beat() == StopWord::go);
  bench.node.on_message(Emergency{kStopNode + 1, 0xFF01, 1, {}}, bench.now_ns);
  bench.node.on_message(NoMessage::bad_size, bench.now_ns);
  CHECK(bench.node.word(bench.now_ns) == StopWord::go);
}
