// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/ipv4_interfaces.hpp"

#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/own_network.hpp"

using namespace g3d;
using hal::Ipv4Interface;

namespace {

hal::Ipv4Interfaces list_now() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const hal::Ipv4Interfaces found = hal::list_ipv4_interfaces(fd);
  ::close(fd);
  return found;
}

}  // namespace

TEST_CASE("the loopback interface is found, with its address and nature") {
  const hal::Ipv4Interfaces found = list_now();
  const auto all = found.all();
  const auto lo = std::find_if(all.begin(), all.end(), [](const Ipv4Interface& one) { return one.is_loopback; });
  REQUIRE(lo != all.end());
  CHECK(lo->text() == "lo");
  CHECK(lo->ipv4 == 0x7F000001U);
  CHECK(lo->index == static_cast<int>(::if_nametoindex("lo")));
  CHECK(lo->is_running);
  // Each once, however many addresses it has.
  for (const Ipv4Interface& one : all) {
    CHECK(std::count_if(all.begin(), all.end(), [&](const Ipv4Interface& o) { return o.index == one.index; }) == 1);
  }
}

TEST_CASE("an interface that is down does not run") {
  (void)test::in_own_network([] {
    const auto runs = [] {
      const hal::Ipv4Interfaces found = list_now();
      return std::any_of(found.all().begin(), found.all().end(),
                         [](const Ipv4Interface& one) { return one.is_running; });
    };
    CHECK_FALSE(runs());
    REQUIRE(test::set_interface_up("lo", true));
    CHECK(runs());
    REQUIRE(test::set_interface_up("lo", false));
    CHECK_FALSE(runs());
  });
}

TEST_CASE("where there is no socket nothing is listed") { CHECK(hal::list_ipv4_interfaces(-1).count == 0); }
