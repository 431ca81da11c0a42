// SPDX-License-Identifier: Apache-2.0
#include "net/key_file_watch.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "net/fleet_key_file.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kWatch_s = 1'000'000'000;

}  // namespace

TEST_CASE("a key's file is read when it was changed, once a second at most", "[net]") {
  const test::TempFolder folder;
  const std::string path = folder / "fleet.key";
  net::FleetKey keys = net::generate_fleet_key();
  REQUIRE(net::write_fleet_key(path, keys));
  net::KeyFileWatch watch(path);
  auto first = watch.look(kWatch_s);
  REQUIRE(first);
  REQUIRE(first->ok());
  CHECK(first->value().epoch == 1);
  CHECK_FALSE(watch.look(3 * kWatch_s));  // the same file

  net::rotate_fleet_key(keys, net::OldKey::kept_until_finished);
  REQUIRE(net::write_fleet_key(path, keys));
  CHECK_FALSE(watch.look(3 * kWatch_s + kWatch_s / 2));  // too soon after the last look
  auto rotated = watch.look(4 * kWatch_s);
  REQUIRE(rotated);
  REQUIRE(rotated->ok());
  CHECK(rotated->value().epoch == 2);
  CHECK(rotated->value().previous.has_value());
  CHECK(watch.rejected() == 0);
}

TEST_CASE("a key's file that is bad or gone is told once, and counted", "[net]") {
  const test::TempFolder folder;
  const std::string path = folder / "fleet.key";
  REQUIRE(net::write_fleet_key(path, net::generate_fleet_key()));
  net::KeyFileWatch watch(path);
  REQUIRE(watch.look(0));
  REQUIRE(::chmod(path.c_str(), 0644) == 0);
  auto open_to_all = watch.look(1 * kWatch_s);
  REQUIRE(open_to_all);
  CHECK(open_to_all->error().reason == hal::Reason::no_permission);
  CHECK_FALSE(watch.look(2 * kWatch_s));
  REQUIRE(::unlink(path.c_str()) == 0);
  auto gone = watch.look(3 * kWatch_s);
  REQUIRE(gone);
  CHECK(gone->error().reason == hal::Reason::not_found);
  CHECK_FALSE(watch.look(4 * kWatch_s));
  CHECK(watch.rejected() == 2);
  REQUIRE(net::write_fleet_key(path, net::generate_fleet_key()));
  const auto back = watch.look(5 * kWatch_s);
  REQUIRE(back);
  CHECK(back->ok());
}
