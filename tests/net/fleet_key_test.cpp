// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_key.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d::net;

TEST_CASE("a new fleet has a key of its own and nothing else") {
  const FleetKey a = generate_fleet_key(), b = generate_fleet_key();
  CHECK(a.epoch == 1);
  CHECK_FALSE(a.key.equals(b.key));
  CHECK_FALSE(a.previous);
  CHECK(a.revoked.empty());
}

TEST_CASE("a rotation keeps the old key until it is finished") {
  FleetKey keys = generate_fleet_key();
  const SecretKey old = keys.key.copy();
  rotate_fleet_key(keys, OldKey::kept_until_finished);
  CHECK(keys.epoch == 2);
  CHECK(keys.previous_epoch() == 1);
  REQUIRE(keys.previous);
  CHECK(keys.previous->equals(old));
  CHECK_FALSE(keys.key.equals(old));
  finish_rotation(keys);
  CHECK_FALSE(keys.previous);
  CHECK(keys.epoch == 2);
}

TEST_CASE("shutting out drops the old key at once, and that before it") {
  FleetKey keys = generate_fleet_key();
  rotate_fleet_key(keys, OldKey::kept_until_finished);
  const SecretKey old = keys.key.copy();
  rotate_fleet_key(keys, OldKey::shut_out);
  CHECK(keys.epoch == 3);
  CHECK_FALSE(keys.previous);
  CHECK_FALSE(keys.key.equals(old));
}

TEST_CASE("the epoch after the last is the first") {
  FleetKey keys = generate_fleet_key();
  keys.epoch = 65535;
  rotate_fleet_key(keys, OldKey::kept_until_finished);
  CHECK(keys.epoch == 0);
  CHECK(keys.previous_epoch() == 65535);
}

TEST_CASE("robots are revoked once each, up to a limit, and stay revoked in a rotation") {
  FleetKey keys = generate_fleet_key();
  for (std::uint64_t robot = 0; robot < FleetKey::kMostRevoked; ++robot) REQUIRE(revoke_robot(keys, robot).ok());
  CHECK(revoke_robot(keys, 7).ok());
  CHECK(keys.revoked.size() == FleetKey::kMostRevoked);
  CHECK(revoke_robot(keys, 1'000'000).error().reason == g3d::hal::Reason::no_capacity);
  rotate_fleet_key(keys, OldKey::shut_out);
  CHECK(keys.has_revoked(7));
  CHECK_FALSE(keys.has_revoked(1'000'000));
}

TEST_CASE("a robot whose layers are dropped is revoked as well, or nothing has changed") {
  FleetKey keys = generate_fleet_key();
  REQUIRE(revoke_robot(keys, 5).ok());
  CHECK_FALSE(keys.has_dropped(5));
  for (const std::uint64_t robot : {5U, 6U, 6U}) REQUIRE(drop_robot(keys, robot).ok());
  CHECK(keys.revoked == std::vector<std::uint64_t>{5, 6});
  CHECK(keys.dropped == std::vector<std::uint64_t>{5, 6});
  for (std::uint64_t robot = 100; keys.revoked.size() < FleetKey::kMostRevoked; ++robot) {
    REQUIRE(revoke_robot(keys, robot).ok());
  }
  CHECK(drop_robot(keys, 7).error().reason == g3d::hal::Reason::no_capacity);
  CHECK_FALSE(keys.has_dropped(7));
  CHECK(drop_robot(keys, 100).ok());
  rotate_fleet_key(keys, OldKey::shut_out);
  CHECK(keys.has_dropped(100));
}

TEST_CASE("robots have hexadecimal names") {
  CHECK(parse_robot_id("0") == 0U);
  CHECK(parse_robot_id("00000000DeadBeef") == 0xDEADBEEFU);
  CHECK(parse_robot_id("ffffffffffffffff") == ~std::uint64_t{0});
  for (const char* bad : {"", "-1", "+1", " 1", "1 ", "0x1", "g", "00000000000000001"})
    CHECK_FALSE(parse_robot_id(bad));
}

}  // namespace
