// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/network_card.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "hal/linux/ipv4_interfaces.hpp"
#include "tests/support/own_network.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("network cards are those of Ethernet", "[boot]") {
  const test::TempFolder folder;
  test::write_plain(folder / "lo/type", "772\n");
  test::write_plain(folder / "can0/type", "280\n");
  test::write_plain(folder / "eth1/type", "1\n");
  test::write_plain(folder / "eth0/type", "1\n");
  CHECK(ethernet_cards(folder.path()) == std::vector<std::string>{"eth0", "eth1"});
  CHECK(ethernet_cards(folder.path() + "/none").empty());
}

TEST_CASE("a card is switched on and takes an address", "[boot]") {
  (void)test::in_own_network([] {
    REQUIRE(switch_on("lo").ok());
    REQUIRE(set_address("lo", 0x0A010203, 24).ok());
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const hal::Ipv4Interfaces found = hal::list_ipv4_interfaces(fd);
    ::close(fd);
    REQUIRE(found.count == 1);
    CHECK(found.list[0].ipv4 == 0x0A010203);
    CHECK(found.list[0].is_running);
    CHECK_FALSE(mac_of("lo"));  // no Ethernet
    CHECK(index_of("lo") > 0);
  });
}

TEST_CASE("what is no card is an error that names it", "[boot]") {
  CHECK(switch_on("no_such_card").error().text.find("no_such_card") != std::string::npos);
  CHECK_FALSE(set_address("no_such_card", 1, 24).ok());
  CHECK(index_of("no_such_card") == 0);
  // This kernel may have no CAN at all; then it says so.
  (void)test::in_own_network([] {
    const auto made = make_virtual_can("vcan7");
    CHECK(made.ok() == (index_of("vcan7") > 0));
    if (!made.ok()) CHECK(made.error().text.find("vcan7") != std::string::npos);
  });
}
