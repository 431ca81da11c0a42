// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/multicast_group.hpp"

#include <poll.h>

#include <catch2/catch.hpp>
#include <vector>

#include "hal/linux/udp_socket.hpp"
#include "tests/support/own_network.hpp"

using namespace g3d;

namespace {

constexpr std::uint32_t kGroup_ipv4 = 0xEFFF474D;

std::unique_ptr<hal::UdpSocket> listener() {
  hal::UdpSocketOptions options;
  options.bind = {kGroup_ipv4, 0};
  auto opened = hal::UdpSocket::open(options);
  REQUIRE(opened);
  return std::move(opened).value();
}

}  // namespace

TEST_CASE("a group is joined on the interface of that name alone") {
  const auto socket = listener();
  hal::MulticastGroup group(socket->fd(), kGroup_ipv4, "lo");
  CHECK(group.joined().empty());
  group.refresh();
  REQUIRE(group.joined().size() == 1);
  CHECK(group.joined()[0] == hal::Leaving{static_cast<int>(::if_nametoindex("lo")), 0x7F000001});
  group.refresh();
  CHECK(group.counts().joined == 1);
  hal::MulticastGroup nowhere(socket->fd(), kGroup_ipv4, "wlan-that-is-not");
  nowhere.refresh();
  CHECK(nowhere.joined().empty());
}

TEST_CASE("an interface that went is left, and joined again when it is back") {
  (void)test::in_own_network([] {
    const auto socket = listener();
    hal::MulticastGroup group(socket->fd(), kGroup_ipv4, "");
    group.refresh();
    CHECK(group.joined().empty());
    const std::vector<std::uint8_t> word{1, 2, 3};
    const auto is_heard = [&] {
      const hal::Ipv4Endpoint to{kGroup_ipv4, socket->bound().port};
      for (const hal::Leaving& leaving : group.joined()) (void)socket->send(to, word, leaving);
      pollfd wait{socket->fd(), POLLIN, 0};
      (void)::poll(&wait, 1, 20);
      return socket->receive().has_value();
    };
    for (std::uint64_t times = 1; times <= 3; ++times) {
      REQUIRE(test::set_interface_up("lo", true));
      group.refresh();
      CHECK(group.joined().size() == 1);
      CHECK(group.counts().joined == times);
      CHECK(is_heard());
      REQUIRE(test::set_interface_up("lo", false));
      CHECK_FALSE(is_heard());
      group.refresh();
      CHECK(group.joined().empty());
      CHECK(group.counts().left == times);
    }
    CHECK(socket->counts().unreachable == 3);
    CHECK(group.counts().refused == 0);
  });
}
