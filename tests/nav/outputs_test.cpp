// SPDX-License-Identifier: Apache-2.0
#include "nav/outputs.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "mapper/files/any_map.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

TEST_CASE("every file of a finished map is written and counted", "[nav][outputs]") {
  const test::TempFolder folder;
  const auto map = tests::furnished_room(0.1F);
  const nav::Outputs outputs = nav::write_outputs(*map, {}, folder.path());
  CHECK(outputs.failures.empty());
  for (const char* name :
       {"map.g3d", "map.ot", "map.bt", "map.ply", "ground.yaml", "ground.pgm", "map.png", "top.png"}) {
    CHECK(std::filesystem::file_size(folder / name) > 0);
  }
  CHECK(outputs.map_file_bytes == std::filesystem::file_size(folder / "map.g3d"));
  for (const mapper::WrittenFile& file : outputs.files) CHECK(file.bytes == std::filesystem::file_size(file.path));
  const auto read = mapper::read_any_map(folder / "map.g3d");
  REQUIRE(read.ok());
  CHECK(tests::same_map(*read.value().map, *map));
}

TEST_CASE("one file that cannot be written does not stop the others", "[nav][outputs]") {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder / "map.bt/in_the_way");
  const auto map = tests::furnished_room(0.1F);
  const nav::Outputs outputs = nav::write_outputs(*map, {}, folder.path());
  REQUIRE(outputs.failures.size() == 1);
  CHECK(outputs.failures[0].text.find("map.bt") != std::string::npos);
  CHECK(std::filesystem::is_regular_file(folder / "map.ply"));
  CHECK(std::filesystem::is_regular_file(folder / "ground.yaml"));
}

TEST_CASE("a failed native file is not counted as one", "[nav][outputs]") {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder / "map.g3d/in_the_way");
  const auto map = tests::furnished_room(0.1F);
  const nav::Outputs outputs = nav::write_outputs(*map, {}, folder.path());
  CHECK(outputs.failures.size() == 1);
  CHECK(outputs.map_file_bytes == 0);
}

TEST_CASE("an unknown ending is refused and names those that are known", "[nav][outputs]") {
  const auto map = tests::furnished_room(0.2F);
  const auto written = nav::write_as(*map, {}, "/tmp/map.doc");
  REQUIRE_FALSE(written.ok());
  CHECK(written.error().reason == hal::Reason::unsupported);
  CHECK(written.error().text.find("map.doc") != std::string::npos);
  CHECK(written.error().text.find(".ply") != std::string::npos);
}

TEST_CASE("of a map that is larger than memory the native file is written", "[nav][outputs]") {
  const test::TempFolder folder;
  const auto map = tests::furnished_room(0.1F);
  const nav::Outputs outputs = nav::write_native_output(mapper::MemoryBlocks(*map), {}, folder.path());
  CHECK(outputs.failures.empty());
  REQUIRE(outputs.files.size() == 1);
  CHECK(outputs.files[0].path == folder / "map.g3d");
  CHECK(outputs.map_file_bytes == std::filesystem::file_size(folder / "map.g3d"));
  CHECK(outputs.files[0].bytes == outputs.map_file_bytes);
  const auto read = mapper::read_any_map(folder / "map.g3d");
  REQUIRE(read.ok());
  CHECK(tests::same_map(*read.value().map, *map));

  const nav::Outputs failed =
      nav::write_native_output(mapper::MemoryBlocks(*map), {}, folder.path() + "/no_such_folder");
  CHECK(failed.failures.size() == 1);
  CHECK(failed.files.empty());
  CHECK(failed.map_file_bytes == 0);
}
