// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/network_keeper.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>

#include "hal/clock.hpp"
#include "tests/support/own_network.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

namespace {
// What it says is what the emulated machine is tested with too; here between two ends of a cable in memory.
bool make_cable() {
  return std::system("ip link add one type veth peer name two 2>/dev/null && ip link set two up") == 0;
}
}  // namespace

TEST_CASE("a card without a given address takes a link-local one, and answers to its name", "[boot][slow]") {
  (void)test::in_own_network([] {
    if (!make_cable()) {
      WARN("skipped: no veth here");
      return;
    }
    const hal::RealClock clock;
    auto first = NetworkKeeper::start({"robot1", "one", {}, {}}, clock.now());
    auto second = NetworkKeeper::start({"robot2", "two", {}, {}}, clock.now());
    REQUIRE(first.ok());
    REQUIRE(second.ok());
    const hal::TimeNs until_ns = clock.now() + 20'000'000'000;
    while ((!first.value()->address() || !second.value()->address()) && clock.now() < until_ns) {
      first.value()->on_time(clock.now());
      second.value()->on_time(clock.now());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    REQUIRE(first.value()->address());
    REQUIRE(second.value()->address());
    CHECK(*first.value()->address() >> 16U == 0xA9FE);
    CHECK(*first.value()->address() != *second.value()->address());
    CHECK(first.value()->take_troubles().empty());

    // Somebody asks on the first one's cable. From its own machine: what comes from the second one's would look forged
    // here.
    REQUIRE(test::set_interface_up("lo", true));
    auto asker = hal::UdpSocket::open({{*first.value()->address(), 0}, false, 255, 1500, 1 << 16});
    REQUIRE(asker.ok());
    const std::uint8_t question[] = {0,   9,   0,   0,   0, 1,   0,   0,   0,   0,   0, 0, 6, 'r', 'o',
                                     'b', 'o', 't', '1', 5, 'l', 'o', 'c', 'a', 'l', 0, 0, 1, 0,   1};
    std::optional<hal::UdpSocket::Received> answer;
    for (int i = 0; i < 200 && !answer; ++i) {
      if (i % 20 == 0) {
        (void)asker.value()->send({kMdnsGroup_ipv4, kMdnsPort}, question,
                                  hal::Leaving{static_cast<int>(::if_nametoindex("one")), *first.value()->address()});
      }
      first.value()->on_time(clock.now());
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      answer = asker.value()->receive();
    }
    REQUIRE(answer);
    CHECK(answer->from == hal::Ipv4Endpoint{*first.value()->address(), kMdnsPort});
    CHECK(first.value()->mdns_answers() > 0);
  });
}

TEST_CASE("a fixed address is taken at once", "[boot]") {
  (void)test::in_own_network([] {
    if (!make_cable()) {
      WARN("skipped: no veth here");
      return;
    }
    auto keeper = NetworkKeeper::start({"robot1", "one", FixedAddress{0x0A000007, 24}, 0x0A000001}, 0);
    REQUIRE(keeper.ok());
    CHECK(keeper.value()->address() == 0x0A000007U);
    CHECK(keeper.value()->take_troubles().empty());
    CHECK(keeper.value()->fds().size() == 1);
    CHECK_FALSE(NetworkKeeper::start({"robot1", "lo", {}, {}}, 0).ok());
    CHECK_FALSE(NetworkKeeper::start({"robot1", "none", {}, {}}, 0).ok());
  });
}
