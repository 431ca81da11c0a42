// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/kinect/calibration.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("a calibration file of nothing is a typical Kinect; what is written is read back") {
  const auto nothing = parse_calibration("# none yet\n", "k.toml");
  REQUIRE(nothing.ok());
  CHECK(nothing.value() == Calibration{});
  Calibration measured;
  measured.serial = "A00364A12345678A";
  measured.colour = {517.25, 516.5, 318.6, 255.3};
  measured.infrared.fx_px = 594.2;
  measured.shift_x_px = 4.0;
  measured.depth_offset_m = -0.012;
  measured.depth_quadratic_perm = 0.0021;
  measured.z_forward = -1.0;
  const auto again = parse_calibration(calibration_text(measured), "k.toml");
  REQUIRE(again.ok());
  CHECK(again.value() == measured);
  const g3d::test::TempFolder folder;
  g3d::test::write_plain(folder / "k.toml", calibration_text(measured));
  const auto loaded = load_calibration(folder / "k.toml");
  REQUIRE(loaded.ok());
  CHECK(loaded.value() == measured);
  CHECK(load_calibration(folder / "none.toml").error().reason == Reason::not_found);
}

TEST_CASE(
    "models of a calibration: registered depth is seen by the colour camera, raw depth by the shifted infrared one") {
  Calibration c;
  c.colour.fx_px = 517.25;
  c.infrared.cx_px = 320.0;
  c.shift_x_px = 4.0;
  c.shift_y_px = -3.0;
  CHECK(colour_model(c).fx_px == 517.25F);
  CHECK(colour_model(c).depth_units_per_metre == 1000.0F);
  CHECK(infrared_model(c).cx_px == 324.0F);
  CHECK(infrared_model(c).cy_px == 236.5F);
}

TEST_CASE("what is wrong with a calibration file is said with its line and what is allowed") {
  struct Case {
    const char* text;
    Reason reason;
    const char* says;
  };
  for (const Case& c :
       {Case{"\n[colour]\nfx_px = 50\n", Reason::out_of_range, "k.toml:3: colour.fx_px is 50, allowed are 200 to 2000"},
        Case{"[colour]\nfx_px = nan\n", Reason::out_of_range, "k.toml:2"},
        Case{"[colour]\nfx = 500\n", Reason::malformed, "colour.fx is not known; here are fx_px fy_px"},
        Case{"[color]\n", Reason::malformed, "color is not known; here are serial [colour] [infrared]"},
        Case{"colour = 3\n", Reason::malformed, "colour is not known"},
        Case{"[depth]\nscale = \"1\"\n", Reason::malformed, "depth.scale must be a number from 0.8 to 1.2"},
        Case{"serial = 7\n", Reason::malformed, "serial must be a text"},
        Case{"[accelerometer]\nz_forward = 0.5\n", Reason::out_of_range, "z_forward must be 1 or -1"},
        Case{"[depth\n", Reason::malformed, "k.toml:1"},
        Case{"# K\xC3\xBC\n", Reason::malformed, "k.toml:1: byte 0xC3"}}) {
    const auto parsed = parse_calibration(c.text, "k.toml");
    INFO(c.text);
    REQUIRE_FALSE(parsed.ok());
    CHECK(parsed.error().reason == c.reason);
    CHECK_THAT(parsed.error().text, Catch::Contains(c.says));
  }
  CHECK(parse_calibration(std::string(kMaxCalibration_bytes + 1, '#'), "k.toml").error().reason == Reason::too_large);
}
