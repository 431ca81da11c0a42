// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_file.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "hal/image/file_bytes.hpp"

using namespace g3d;
using mapper::State;

namespace {

nav::GroundGrid small_grid() {
  return {0.05F, -1.25, 2.5,
          3,     2,     {State::occupied, State::free, State::unknown, State::free, State::free, State::occupied}};
}

}  // namespace

TEST_CASE("The picture's first row is the highest y") {
  const hal::GreyImage image = nav::ground_image(small_grid());
  CHECK(image.size == hal::ImageSize{3, 2});
  CHECK(image.pixels == std::vector<std::uint8_t>{254, 254, 0, 0, 254, 205});
}

TEST_CASE("The yaml is what map_server reads") {
  CHECK(nav::ground_yaml(small_grid(), "ground.pgm") ==
        "image: ground.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.250000, 2.500000, 0.000000]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST_CASE("map_server's thresholds give back the three states") {
  // map_server, trinary: p = (255 - grey) / 255; occupied above occupied_thresh, free below free_thresh
  const auto p = [](std::uint8_t grey) { return (255 - grey) / 255.0; };
  CHECK(p(nav::kOccupiedGrey) > 0.65);
  CHECK(p(nav::kFreeGrey) < 0.196);
  CHECK(p(nav::kUnknownGrey) > 0.196);
  CHECK(p(nav::kUnknownGrey) < 0.65);
}

TEST_CASE("Both files are written side by side") {
  std::string folder = (std::filesystem::temp_directory_path() / "g3d_ground_XXXXXX").string();
  REQUIRE(mkdtemp(folder.data()) != nullptr);
  REQUIRE(nav::write_ground(small_grid(), folder + "/ground").ok());
  const auto image = hal::read_pgm(folder + "/ground.pgm");
  REQUIRE(image.ok());
  CHECK(image.value().pixels == nav::ground_image(small_grid()).pixels);
  const auto yaml = hal::read_text_file(folder + "/ground.yaml", 10000);
  REQUIRE(yaml.ok());
  CHECK(yaml.value() == nav::ground_yaml(small_grid(), "ground.pgm"));
  CHECK(nav::write_ground({}, folder + "/empty").ok());
  CHECK_FALSE(nav::write_ground(small_grid(), folder + "/none/ground").ok());
  std::filesystem::remove_all(folder);
}
