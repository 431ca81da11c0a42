// SPDX-License-Identifier: Apache-2.0
#include "net/robot_identity.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "net/fleet_key.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using test::write_plain;

namespace {

net::MachineFiles machine_in(const test::TempFolder& folder) { return {folder / "machine-id", folder / "net"}; }

void add_card(const test::TempFolder& folder, const std::string& name, const std::string& address, bool is_real) {
  const std::string card = folder / ("net/" + name);
  std::filesystem::create_directories(is_real ? card + "/device" : card);
  write_plain(card + "/address", address + "\n");
}

}  // namespace

TEST_CASE("a machine's name is the same at every start, another one elsewhere, and does not betray its id", "[net]") {
  const test::TempFolder folder;
  const net::MachineFiles files = machine_in(folder);
  write_plain(files.machine_id, "0123456789abcdef0123456789abcdef\n");
  const auto first = net::machine_robot_id(files);
  REQUIRE(first);
  CHECK(first.value() == net::machine_robot_id(files).value());
  CHECK(net::text_of_robot(first.value()).find("0123456789abcdef") == std::string::npos);
  write_plain(files.machine_id, "0123456789abcdef0123456789abcdee\n");
  CHECK(net::machine_robot_id(files).value() != first.value());
}

TEST_CASE("a machine without an id is named by its network card", "[net]") {
  const test::TempFolder folder;
  const net::MachineFiles files = machine_in(folder);
  const auto nameless = net::machine_robot_id(files);
  REQUIRE_FALSE(nameless);
  CHECK(nameless.error().reason == hal::Reason::not_found);
  CHECK(nameless.error().text.find("--robot") != std::string::npos);

  add_card(folder, "lo", "00:00:00:00:00:00", true);
  add_card(folder, "docker0", "02:00:00:00:00:01", false);  // made anew at each start
  CHECK_FALSE(net::machine_robot_id(files));
  add_card(folder, "wlan0", "00:04:4b:aa:bb:cc", true);
  const auto by_radio = net::machine_robot_id(files);
  REQUIRE(by_radio);
  add_card(folder, "eth0", "00:04:4b:aa:bb:cd", true);
  CHECK(net::machine_robot_id(files).value() == by_radio.value());
  write_plain(files.machine_id, "uninitialized\n");
  CHECK(net::machine_robot_id(files).value() == by_radio.value());
}

TEST_CASE("an incarnation is never 0 and hardly ever the same", "[net]") {
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 100; ++i) seen.insert(net::fresh_incarnation());
  CHECK(seen.size() == 100);
  CHECK(seen.count(0) == 0);
}

TEST_CASE("names are written as the command line takes them", "[net]") {
  CHECK(net::text_of_robot(0xC0FFEE) == "0000000000c0ffee");
  CHECK(net::parse_robot_id(net::text_of_robot(0xC0FFEE)) == std::uint64_t{0xC0FFEE});
  CHECK(net::text_of_layer({0xA1, 7}) == "00000000000000a1.00000007");
}
