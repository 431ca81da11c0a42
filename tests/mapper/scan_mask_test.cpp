// SPDX-License-Identifier: Apache-2.0
#include "mapper/scan_mask.hpp"

#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/image/png_writer.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

namespace {
const hal::CameraModel kCamera{.width_px = 4, .height_px = 2};
}

TEST_CASE("the nearest reading of a pixel counts, none at all stays zero", "[mapper][scan_mask]") {
  mapper::ScanMaskBuilder builder(kCamera);
  CHECK(builder.coverage() == 0.0);
  hal::Frame frame = hal::make_frame(kCamera);
  frame.depth[0] = 3000;
  frame.depth[1] = 2500;
  builder.add(frame);
  frame.depth[0] = 2900;
  frame.depth[1] = 0;
  frame.depth[7] = 65535;
  builder.add(frame);
  CHECK(builder.mask() == std::vector<std::uint16_t>{2900, 2500, 0, 0, 0, 0, 0, 65535});
  CHECK(builder.coverage() == Approx(3.0 / 8.0));
}

TEST_CASE("a mask comes back from its picture", "[mapper][scan_mask]") {
  const test::TempFolder folder;
  const std::vector<std::uint16_t> mask{1, 2, 3, 4, 5000, 60000, 0, 65535};
  REQUIRE(mapper::save_scan_mask(folder / "mask.png", kCamera, mask).ok());
  const auto loaded = mapper::load_scan_mask(folder / "mask.png", kCamera);
  REQUIRE(loaded.ok());
  CHECK(loaded.value() == mask);
}

TEST_CASE("a mask of another size or kind is refused by name", "[mapper][scan_mask]") {
  const test::TempFolder folder;
  const std::vector<std::uint16_t> mask(8, 1000);
  REQUIRE(mapper::save_scan_mask(folder / "mask.png", kCamera, mask).ok());
  REQUIRE(hal::write_png_rgb(folder / "rgb.png", {4, 2}, std::vector<std::uint8_t>(24)).ok());
  const auto other_size = mapper::load_scan_mask(folder / "mask.png", {.width_px = 8, .height_px = 1});
  const auto colour = mapper::load_scan_mask(folder / "rgb.png", kCamera);
  const auto missing = mapper::load_scan_mask(folder / "none.png", kCamera);
  REQUIRE_FALSE(other_size.ok());
  CHECK(other_size.error().text.find("mask.png") != std::string::npos);
  REQUIRE_FALSE(colour.ok());
  CHECK(colour.error().text.find("rgb.png") != std::string::npos);
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().text.find("none.png") != std::string::npos);
}
