// SPDX-License-Identifier: Apache-2.0
#include "net/port_mux.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <utility>
#include <vector>

using namespace g3d;
using namespace g3d::net;

namespace {

constexpr hal::TimeNs kMuxSecond_ns = 1'000'000'000;

/// A port that keeps what it is given.
struct KeepingPort final : DatagramPort {
  bool send(Address to, mapper::ByteSpan datagram) override {
    if (!is_open) return false;
    sent.emplace_back(to, datagram.size());
    return true;
  }
  std::optional<Received> receive() override {
    if (inbox.empty()) return std::nullopt;
    last = std::move(inbox.front());
    inbox.pop_front();
    return Received{last.first, last.second};
  }
  [[nodiscard]] bool has_room(Address) const override { return is_open; }
  bool is_open = true;
  std::vector<std::pair<Address, std::size_t>> sent;
  std::deque<std::pair<Address, mapper::Bytes>> inbox;
  std::pair<Address, mapper::Bytes> last;
};

using Sent = std::vector<std::pair<Address, std::size_t>>;

}  // namespace

TEST_CASE("an answer leaves by the port that it came from, what is for everybody by all") {
  KeepingPort radio, broker;
  PortMux mux({{&radio, 0.0}, {&broker, 0.0}});
  radio.inbox.emplace_back(7, mapper::Bytes(1));
  broker.inbox.emplace_back(7, mapper::Bytes(2));
  const auto first = mux.receive(), second = mux.receive();
  REQUIRE(first);
  REQUIRE(second);
  CHECK_FALSE(mux.receive());
  CHECK(first->from != second->from);
  CHECK(mux.branch_of(first->from) == 0);
  CHECK(mux.branch_of(second->from) == 1);
  CHECK(PortMux::within_branch(second->from) == 7);
  CHECK(mux.send(first->from, mapper::Bytes(10)));
  CHECK(mux.send(second->from, mapper::Bytes(20)));
  CHECK(mux.send(kEverybody, mapper::Bytes(30)));
  CHECK(radio.sent == Sent{{7, 10}, {kEverybody, 30}});
  CHECK(broker.sent == Sent{{7, 20}, {kEverybody, 30}});
  CHECK(mux.counts(1).sent_bytes == 50);
  CHECK(mux.counts(0).received == 1);
}

TEST_CASE("addresses of no port lead nowhere, and ports that give such are not believed") {
  KeepingPort radio, broker;
  PortMux mux({{&radio, 0.0}, {&broker, 0.0}});
  for (const Address address : {Address{7}, kMostPortAddress, (Address{3} << 56U) + 7, ~Address{0}}) {
    CHECK_FALSE(mux.send(address, mapper::Bytes(10)));
  }
  CHECK(radio.sent.empty());
  CHECK(broker.sent.empty());
  radio.inbox.emplace_back(kMostPortAddress + 1, mapper::Bytes(1));
  radio.inbox.emplace_back(kEverybody, mapper::Bytes(1));
  radio.inbox.emplace_back(kMostPortAddress, mapper::Bytes(1));
  int came = 0;
  for (int i = 0; i < 10; ++i) came += mux.receive() ? 1 : 0;
  CHECK(came == 1);
  CHECK(mux.counts(0).foreign_addresses == 2);
}

TEST_CASE("a flood at one port leaves the other its turns") {
  KeepingPort radio, broker;
  PortMux mux({{&radio, 0.0}, {&broker, 0.0}});
  for (int i = 0; i < 100; ++i) broker.inbox.emplace_back(1, mapper::Bytes(1));
  for (int i = 0; i < 5; ++i) radio.inbox.emplace_back(1, mapper::Bytes(1));
  int of_radio = 0;
  for (int i = 0; i < 10; ++i) {
    const auto received = mux.receive();
    REQUIRE(received);
    of_radio += mux.branch_of(received->from) == 0U ? 1 : 0;
  }
  CHECK(of_radio == 5);
}

TEST_CASE("a port with a bandwidth is given no more than that, and says beforehand when data should wait") {
  KeepingPort radio, broker;
  PortMux mux({{&radio, 0.0}, {&broker, 50'000.0}});
  const Address far = (Address{2} << 56U) | 9, near = (Address{1} << 56U) | 9;
  hal::TimeNs now_ns = 5 * kMuxSecond_ns;
  mux.on_time(now_ns);
  std::size_t polite_bytes = 0;
  for (const hal::TimeNs end_ns = now_ns + 2 * kMuxSecond_ns; now_ns < end_ns; now_ns += kMuxSecond_ns / 100) {
    mux.on_time(now_ns);
    while (mux.has_room(far)) {
      CHECK(mux.send(far, mapper::Bytes(1200)));
      polite_bytes += 1200;
    }
    CHECK(mux.has_room(near));
  }
  CHECK(polite_bytes >= 99'000);
  CHECK(polite_bytes <= 104'000);
  CHECK(mux.counts(1).over_bandwidth == 0);
  // Who does not ask is cut off soon, and the other port goes on.
  int sent = 0;
  for (int i = 0; i < 100; ++i) sent += mux.send(far, mapper::Bytes(1200)) ? 1 : 0;
  CHECK(sent <= 4);
  CHECK(mux.counts(1).over_bandwidth == static_cast<std::uint64_t>(100 - sent));
  CHECK(mux.send(kEverybody, mapper::Bytes(100)));
  CHECK(radio.sent == Sent{{kEverybody, 100}});
  mux.on_time(now_ns + kMuxSecond_ns);
  CHECK(mux.send(far, mapper::Bytes(100)));
}

TEST_CASE("a closed port has no room, and what it does not take is counted") {
  KeepingPort radio, broker;
  PortMux mux({{&radio, 0.0}, {&broker, 0.0}});
  broker.is_open = false;
  const Address far = (Address{2} << 56U) | 9;
  CHECK_FALSE(mux.has_room(far));
  CHECK(mux.has_room(kEverybody));
  CHECK_FALSE(mux.send(far, mapper::Bytes(10)));
  CHECK(mux.send(kEverybody, mapper::Bytes(10)));
  CHECK(mux.counts(1).not_taken == 2);
  radio.is_open = false;
  CHECK_FALSE(mux.has_room(kEverybody));
  CHECK_FALSE(mux.send(kEverybody, mapper::Bytes(10)));
}
