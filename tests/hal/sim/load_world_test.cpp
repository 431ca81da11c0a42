// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/load_world.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

using namespace g3d::hal;
using Catch::Matchers::Contains;

TEST_CASE("a name that is neither built in nor a file is told with the names there are") {
  const auto world = load_world("furnished_rom");
  REQUIRE_FALSE(world.ok());
  CHECK(world.error().reason == Reason::not_found);
  CHECK_THAT(world.error().text, Contains("furnished_rom") && Contains("furnished_room") && Contains("corridor"));
  CHECK_THAT(load_camera_path("nowhere").error().text, Contains("two_rooms"));
}

TEST_CASE("worlds, paths and floor plans are read from files") {
  const auto folder = std::filesystem::temp_directory_path() / "g3d_load_world_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "a.world") << "box 0 0 0 1 1 1\n";
  std::ofstream(folder / "a.path") << "0 0 0 1 0 0\n";
  std::ofstream(folder / "m.yaml") << "image: m.pgm\nresolution: 0.5\norigin: [0, 0, 0]\n";
  std::ofstream(folder / "m.pgm", std::ios::binary) << "P5\n2 1\n255\n" << std::string("\xFE\x00", 2);
  CHECK(load_world((folder / "a.world").string()).value().primitives().size() == 1);
  CHECK(load_camera_path((folder / "a.path").string()).ok());
  CHECK(load_world((folder / "m.yaml").string()).value().grid().has_value());
  const FloorRectangle left{0, 0, 0.4, 0.5};
  CHECK(load_world((folder / "m.yaml").string(), left).value().grid()->width_cells() == 3);
  CHECK(load_world((folder / "m.yaml").string()).value().grid()->width_cells() == 4);
  const FloorRectangle beside{7, 0, 8, 0.5};
  CHECK_THAT(load_world((folder / "m.yaml").string(), beside).error().text,
             Contains("m.yaml: the rectangle 7,0,8,0.5"));
  CHECK_THAT(load_world((folder / "a.world").string(), left).error().text,
             Contains("a.world: only map_server maps (.yaml) can be cropped"));
  CHECK(load_world("maze", left).error().reason == Reason::bad_usage);
  std::ofstream(folder / "bad.yaml") << "image: none.pgm\nresolution: 0.5\n";
  CHECK(load_world((folder / "bad.yaml").string()).error().reason == Reason::not_found);
  std::filesystem::remove_all(folder);
}
