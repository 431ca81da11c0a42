// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/can_keeper.hpp"

#include <linux/can/error.h>

#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/scripted_can.hpp"

using namespace g3d;
using namespace g3d::hal;

namespace {

constexpr TimeNs kMsK = 1'000'000;

struct KeeperBench {
  explicit KeeperBench(int fd) : socket(fd), keeper(socket, calls()) {}
  CanKeeperCalls calls() {
    CanKeeperCalls calls;
    calls.open_socket = [this]() -> Result<int> {
      if (next_fd < 0) return Error{Reason::not_found, "can0: not there"};
      return std::exchange(next_fd, -1);
    };
    calls.bring_up = [] { return Result<void>{}; };
    calls.restart = [this]() -> Result<void> {
      restarts_ms.push_back(now_ns / kMsK);
      return {};
    };
    return calls;
  }
  void pass(TimeNs ms) {
    for (const TimeNs end_ns = now_ns + ms * kMsK; now_ns < end_ns; now_ns += 10 * kMsK) keeper.tend(now_ns);
  }
  CanSocket socket;
  int next_fd = -1;
  TimeNs now_ns = 0;
  std::vector<TimeNs> restarts_ms;
  CanKeeper keeper;
};

void say_bus_off(const test::CanPair& pair, CanSocket& socket) {
  pair.say(CAN_ERR_FLAG | CAN_ERR_BUSOFF, std::vector<std::uint8_t>(8, 0));
  can::CanFrame frame;
  REQUIRE(socket.read(frame));
}

}  // namespace

TEST_CASE("A bus that is off is restarted, ever more seldom", "[can]") {
  const test::CanPair pair;
  KeeperBench bench(pair.ours);
  bench.pass(1'000);
  CHECK(bench.restarts_ms.empty());
  say_bus_off(pair, bench.socket);
  bench.pass(20'000);
  REQUIRE(bench.restarts_ms.size() >= 5);
  CHECK(bench.restarts_ms[0] >= 1'100);
  CHECK(bench.restarts_ms[0] < 1'150);
  const auto gap = [&](std::size_t i) { return bench.restarts_ms[i] - bench.restarts_ms[i - 1]; };
  CHECK(gap(1) >= 200);
  CHECK(gap(2) >= 400);
  for (std::size_t i = 2; i < bench.restarts_ms.size(); ++i) CHECK(gap(i) >= gap(i - 1) - 10);
  CHECK(gap(bench.restarts_ms.size() - 1) <= 5'010);

  // Well for long enough, it is tried soon again.
  pair.say(0x711, {5});
  can::CanFrame frame;
  REQUIRE(bench.socket.read(frame));
  bench.pass(11'000);
  const std::size_t before = bench.restarts_ms.size();
  say_bus_off(pair, bench.socket);
  const TimeNs off_ms = bench.now_ns / kMsK;
  bench.pass(300);
  REQUIRE(bench.restarts_ms.size() == before + 1);
  CHECK(bench.restarts_ms.back() - off_ms <= 120);
  CHECK(bench.keeper.counts().restarts == bench.restarts_ms.size());
}

TEST_CASE("An interface that is missing is opened when it is there", "[can]") {
  KeeperBench bench(-1);
  bench.pass(3'000);
  CHECK(bench.keeper.counts().openings == 0);
  CHECK(bench.keeper.counts().failed_openings >= 3);
  CHECK(bench.keeper.counts().failed_openings < 10);
  CHECK(bench.keeper.last_error() == "can0: not there");
  const test::CanPair pair;
  bench.next_fd = pair.ours;
  bench.pass(6'000);
  CHECK(bench.keeper.counts().openings == 1);
  pair.say(0x711, {5});
  can::CanFrame frame;
  CHECK(bench.socket.read(frame));
}

TEST_CASE("The real calls name the interface that is not there", "[can]") {
  const CanKeeperCalls calls = can_keeper_calls("nocan7", 500'000);
  REQUIRE(calls.bring_up);
  CHECK(calls.bring_up().error().text.find("nocan7") == 0);
  CHECK(calls.restart().error().text.find("nocan7") == 0);
  CHECK_FALSE(calls.open_socket().ok());
  CHECK_FALSE(can_keeper_calls("nocan7", 0).bring_up);
}
