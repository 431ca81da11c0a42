// SPDX-License-Identifier: Apache-2.0
#include "net/broker_options.hpp"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::net;

TEST_CASE("a board's words about a broker become options, or an error that says what to write") {
  test::TempFolder folder;
  const std::string login = folder / "login";
  test::write_plain(login, "# of this site\nuser warehouse-2\n\npassword a b c\n");
  CHECK(::chmod(login.c_str(), 0600) == 0);
  const auto options = broker_options({"192.0.2.7:1884", "fleet/one", login}, 0x2A);
  REQUIRE(options.ok());
  CHECK(options.value().host == "192.0.2.7");
  CHECK(options.value().port == 1884);
  CHECK(options.value().root == "fleet/one");
  CHECK(options.value().site == 0x2A);
  CHECK(options.value().user == "warehouse-2");
  CHECK(options.value().password == "a b c");
  const auto open = broker_options({"192.0.2.7:1883", "g3dmap", "none"}, ~RobotId{0});
  REQUIRE(open.ok());
  CHECK(open.value().user.empty());
  CHECK(open.value().site <= kMostSiteId);
  for (const char* address : {"", "broker", "192.0.2.7", "192.0.2.7:0", "broker.example.org:1883", "192.0.2.7:99999"}) {
    CAPTURE(address);
    const auto refused = broker_options({address, "g3dmap", "none"}, 1);
    REQUIRE_FALSE(refused.ok());
    CHECK_THAT(refused.error().text, Catch::Contains("write it like 192.0.2.7:1883"));
  }
  CHECK_FALSE(broker_options({"192.0.2.7:1883", "a/#", "none"}, 1).ok());
}

TEST_CASE("a login that others may read, or that is none, is refused without showing it") {
  test::TempFolder folder;
  const std::string path = folder / "login";
  test::write_plain(path, "user a\npassword secret\n");
  CHECK(::chmod(path.c_str(), 0644) == 0);
  const auto open = read_broker_login(path);
  REQUIRE_FALSE(open.ok());
  CHECK(open.error().reason == hal::Reason::no_permission);
  CHECK_THAT(open.error().text, Catch::Contains("chmod 600"));
  CHECK(read_broker_login(folder / "none").error().reason == hal::Reason::not_found);
  CHECK(read_broker_login(folder.path()).error().reason != hal::Reason::malformed);
  test::write_plain(path, std::string(5000, '#'));
  CHECK(::chmod(path.c_str(), 0600) == 0);
  CHECK(read_broker_login(path).error().reason == hal::Reason::too_large);
  for (const char* text : {"", "user a\n", "password secret\n", "secret\n", "user a\npassword\n", "user a\npassword \n",
                           "user a\nuser b\npassword secret\n", "user a\npassword secret\x01\n",
                           "user \xFF\npassword secret\n", "User a\npassword secret\n"}) {
    CAPTURE(text);
    const auto refused = parse_broker_login(text, "f");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().reason == hal::Reason::malformed);
    CHECK_THAT(refused.error().text, Catch::StartsWith("f:"));
    CHECK_THAT(refused.error().text, !Catch::Contains("secret"));
  }
  CHECK(parse_broker_login("password secret\nuser a", "f").ok());
}
