// SPDX-License-Identifier: Apache-2.0
// The relay itself: a test that leans on it must know what it does.
#include "tests/support/datagram_relay.hpp"

#include <poll.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

using namespace g3d;
using test::DatagramRelay;
using test::RelayModel;

namespace {

constexpr hal::TimeNs kRelayMs_ns = 1'000'000;

struct Passed {
  RelayModel model;
  std::vector<mapper::Bytes> arrived;
  test::RelayCounts counts;
  std::uint64_t lost = 0;
};

/// What becomes of 300 datagrams, one each millisecond, from robot 0 to robot 1.
Passed pass(const RelayModel& model, std::vector<test::RelayCut> cuts = {}) {
  DatagramRelay relay(2, model, std::move(cuts));
  hal::UdpSocketOptions here;
  here.bind.ipv4 = 0x7F000001;
  const auto a = hal::UdpSocket::open(here), b = hal::UdpSocket::open(here);
  REQUIRE(a);
  REQUIRE(b);
  const auto door_of = [&](std::uint32_t i) { return *hal::parse_ipv4_endpoint(relay.peers_of(i).at(0)); };
  (void)b.value()->send(door_of(1), mapper::Bytes{1});
  const auto pump_until = [&](std::size_t captured, hal::TimeNs now_ns) {
    do {
      relay.pump(now_ns);
    } while (relay.capture().size() < captured);
  };
  pump_until(1, 0);
  Passed passed;
  const auto listen = [&] {
    while (const auto received = b.value()->receive()) {
      // From there an answer finds its way.
      CHECK(received->from == door_of(1));
      passed.arrived.emplace_back(received->datagram.begin(), received->datagram.end());
    }
  };
  for (int ms = 0; ms < 500; ++ms) {
    const int sent = std::min(ms + 1, 300);
    if (ms < 300) REQUIRE(a.value()->send(door_of(0), mapper::Bytes(20, static_cast<std::uint8_t>(ms))));
    pump_until(static_cast<std::size_t>(sent) + 1, ms * kRelayMs_ns);
    listen();
  }
  pollfd wait{b.value()->fd(), POLLIN, 0};
  while (::poll(&wait, 1, 10) > 0) listen();
  CHECK(relay.capture().size() == 301);
  passed.counts = relay.counts();
  passed.lost = relay.radio().lost();
  return passed;
}

}  // namespace

TEST_CASE("a relay that does nothing passes everything on, in order", "[relay]") {
  const Passed passed = pass({});
  REQUIRE(passed.arrived.size() == 300);
  for (std::size_t i = 0; i < 300; ++i) CHECK(passed.arrived[i] == mapper::Bytes(20, static_cast<std::uint8_t>(i)));
}

TEST_CASE("a relay's mistreatment is what was asked for, and the same for the same seed", "[relay]") {
  RelayModel model;
  model.radio = {0.2, 0.1, 0.1, 2 * kRelayMs_ns, kRelayMs_ns, 60 * kRelayMs_ns, 7};
  model.flipped = 0.1;
  model.truncated = 0.1;
  const Passed once = pass(model), again = pass(model);
  CHECK(once.arrived == again.arrived);
  CHECK(once.lost > 30);
  CHECK(once.lost < 100);
  CHECK(once.counts.flipped > 10);
  CHECK(once.counts.truncated > 10);
  CHECK_FALSE(std::is_sorted(once.arrived.begin(), once.arrived.end()));
  CHECK(std::set(once.arrived.begin(), once.arrived.end()).size() < once.arrived.size());
  model.radio.seed = 8;
  CHECK(pass(model).arrived != once.arrived);
}

TEST_CASE("a relay cuts a link for as long as it is told", "[relay]") {
  const Passed passed = pass({}, {{1, 0, 100 * kRelayMs_ns, 200 * kRelayMs_ns}});
  REQUIRE(passed.arrived.size() == 200);
  CHECK(passed.arrived[99][0] == 99);
  CHECK(passed.arrived[100][0] == 200);
}
