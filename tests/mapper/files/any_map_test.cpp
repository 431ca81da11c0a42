// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/any_map.hpp"

#include <catch2/catch.hpp>

#include "mapper/files/map_file.hpp"
#include "mapper/files/octomap_write.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

TEST_CASE("the ending chooses the reader", "[mapper][files]") {
  const test::TempFolder folder;
  const auto map = tests::furnished_room(0.1F);
  mapper::MapFileMeta meta;
  meta.T_world_map.translation_m = {1, 2, 3};
  REQUIRE(mapper::save_map(*map, meta, folder / "a.g3d").ok());
  REQUIRE(mapper::write_octomap(*map, folder / "a.ot").ok());
  REQUIRE(mapper::write_octomap(*map, folder / "a.bt").ok());

  const auto native = mapper::read_any_map(folder / "a.g3d");
  REQUIRE(native.ok());
  CHECK(tests::same_map(*native.value().map, *map));
  CHECK(native.value().meta.T_world_map.translation_m == meta.T_world_map.translation_m);
  CHECK(native.value().format == "g3d 1");
  CHECK(native.value().file_bytes > 0);
  for (const char* name : {"a.ot", "a.bt"}) {
    const auto tree = mapper::read_any_map(folder / name);
    REQUIRE(tree.ok());
    CHECK(tree.value().map->counts().occupied == map->counts().occupied);
    CHECK(tree.value().map->counts().free == map->counts().free);
  }
}

TEST_CASE("unknown endings and missing files are errors that name the file", "[mapper][files]") {
  const auto unknown = mapper::read_any_map("room.xyz");
  REQUIRE_FALSE(unknown.ok());
  CHECK(unknown.error().reason == hal::Reason::unsupported);
  CHECK(unknown.error().text.find("room.xyz") != std::string::npos);
  for (const char* name : {"/nowhere/a.g3d", "/nowhere/a.ot", "/nowhere/a.bt"}) {
    const auto missing = mapper::read_any_map(name);
    REQUIRE_FALSE(missing.ok());
    CHECK(missing.error().text.find(name) != std::string::npos);
  }
}
