// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/ipv4_endpoint.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("addresses and ports read as they are written") {
  CHECK(parse_ipv4("10.0.0.2") == 0x0A000002U);
  CHECK(parse_ipv4("255.255.255.255") == 0xFFFFFFFFU);
  CHECK(parse_ipv4("0.0.0.0") == 0U);
  for (const char* text : {"192.168.1.20:7177", "239.255.71.77:1", "0.0.0.0:65535"}) {
    const auto endpoint = parse_ipv4_endpoint(text);
    REQUIRE(endpoint);
    CHECK(to_string(*endpoint) == text);
  }
}

TEST_CASE("what is no address is not guessed at") {
  for (const char* text : {"", "10.0.0", "10.0.0.0.1", "10.0.0.256", "010.0.0.1", "10.0.0.1 ", " 10.0.0.1", "10.0.0.-1",
                           "robot1", "10..0.1", "10.0.0.1.", "0x0A.0.0.1", "99999999999.0.0.1"}) {
    INFO(text);
    CHECK_FALSE(parse_ipv4(text));
  }
  for (const char* text : {"10.0.0.1", "10.0.0.1:", "10.0.0.1:0", "10.0.0.1:65536", "10.0.0.1:071", "10.0.0.1:7177x",
                           ":7177", "10.0.0.1:99999999999", "robot1:7177"}) {
    INFO(text);
    CHECK_FALSE(parse_ipv4_endpoint(text));
  }
}

TEST_CASE("groups are told from single addresses") {
  CHECK(is_multicast(0xEFFF474DU));
  CHECK(is_multicast(0xE0000000U));
  CHECK_FALSE(is_multicast(0xDFFFFFFFU));
  CHECK_FALSE(is_multicast(0xF0000000U));
}
