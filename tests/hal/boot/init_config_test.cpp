// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/init_config.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("an empty init.toml keeps every default, and a whole one is read", "[boot]") {
  const auto plain = parse_init_config("", "init.toml");
  REQUIRE(plain.ok());
  CHECK(plain.value() == InitConfig{});

  const auto whole = parse_init_config(R"(name = "robot-7"
[robot]
arguments = ["run", "--board", "/system/board.toml"]
when_done = "power_off"
silent_ms = 5000
start_s = 60
prove_s = 10
[network]
interface = "eth0"
address = "10.0.0.7/24"
gateway = "10.0.0.1"
can_virtual = true
[watchdog]
timeout_s = 20
)",
                                       "init.toml");
  REQUIRE(whole.ok());
  const InitConfig& config = whole.value();
  CHECK(config.name == "robot-7");
  CHECK(config.arguments == std::vector<std::string>{"run", "--board", "/system/board.toml"});
  CHECK(config.when_done == WhenDone::power_off);
  CHECK(config.silent_ms == 5000);
  CHECK(config.start_s == 60);
  CHECK(config.prove_s == 10);
  CHECK(config.interface == "eth0");
  CHECK(config.address == FixedAddress{0x0A000007, 24});
  CHECK(config.gateway == 0x0A000001U);
  CHECK(config.can_virtual);
  CHECK(config.watchdog_s == 20);
}

TEST_CASE("what is wrong with an init.toml is said with file and line", "[boot]") {
  const char* text = GENERATE(
      "name = \"-x\"", "name = \"a.b\"", "name = 7", "nme = \"x\"", "[robots]\n", "[robot]\nx = 1",
      "[robot]\narguments = []", "[robot]\narguments = [\"\"]", "[robot]\narguments = \"run\"",
      "[robot]\narguments = [1]", "[robot]\nwhen_done = \"later\"", "[robot]\nsilent_ms = 100",
      "[robot]\nsilent_ms = 30001", "[robot]\nstart_s = 4.5", "[network]\naddress = \"10.0.0.7\"",
      "[network]\naddress = \"10.0.0.7/31\"", "[network]\naddress = \"10.0.0.256/24\"",
      "[network]\ngateway = \"router\"", "[network]\ninterface = \"a/b\"",
      "[network]\ninterface = \"an_interface_name\"", "[network]\ncan_virtual = 1", "[watchdog]\ntimeout_s = 1",
      "[watchdog]\ntimeout_s = 61", "[watchdog]\nx = 1", "name = ", "name = \"x\" \xC3\xA4", "name = \"x\"\x01");
  const auto read = parse_init_config(text, "some.toml");
  INFO(text);
  REQUIRE_FALSE(read.ok());
  CHECK(read.error().text.find("some.toml:") == 0);
}

TEST_CASE("an init.toml that is too large is not read", "[boot]") {
  const test::TempFolder folder;
  test::write_plain(folder / "init.toml", std::string(100'000, '#'));
  CHECK_FALSE(load_init_config(folder / "init.toml").ok());
  test::write_plain(folder / "init.toml", "name = \"x\"\n");
  CHECK(load_init_config(folder / "init.toml").ok());
  CHECK(load_init_config(folder / "none.toml").error().reason == hal::Reason::not_found);
}

TEST_CASE("addresses are written as people read them", "[boot]") { CHECK(ipv4_text(0xA9FE0102) == "169.254.1.2"); }
