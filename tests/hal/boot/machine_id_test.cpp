// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/machine_id.hpp"

#include <catch2/catch.hpp>
#include <filesystem>

#include "net/robot_identity.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

TEST_CASE("a machine without a name gets one for ever", "[boot]") {
  const test::TempFolder folder;
  const std::string kept = folder / "machine-id", shown = folder / "etc/machine-id";
  REQUIRE(hal::boot::keep_machine_id(kept, shown));
  const std::string first = test::read_plain(kept);
  CHECK(first.size() == 33);
  CHECK(test::read_plain(shown) == first);
  REQUIRE(hal::boot::keep_machine_id(kept, shown));
  CHECK(test::read_plain(shown) == first);
  const auto robot = net::machine_robot_id({.machine_id = shown, .interfaces = folder / "none"});
  REQUIRE(robot.ok());

  // Half an id, as a power cut may leave it where the file system is not ours, is none.
  test::write_plain(kept, first.substr(0, 20));
  REQUIRE(hal::boot::keep_machine_id(kept, shown));
  CHECK(test::read_plain(shown).size() == 33);
  CHECK(test::read_plain(shown) != first);
  CHECK_FALSE(hal::boot::keep_machine_id(kept + "/machine-id", shown));  // no folder
}
