// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/tum_lists.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;

namespace {

std::string camera_error(std::string_view text) {
  const Result<CameraModel> camera = parse_camera(text, "camera.txt");
  REQUIRE_FALSE(camera.ok());
  return camera.error().text;
}

std::string list_error(std::string_view text) {
  const Result<std::vector<ImageEntry>> list = parse_image_list(text, "depth.txt");
  REQUIRE_FALSE(list.ok());
  return list.error().text;
}

}  // namespace

TEST_CASE("camera.txt holds one camera") {
  const CameraModel camera = parse_camera("# comment\n517.3 516.5 318.6 255.3 5000 640 480\n", "c").value();
  CHECK(camera.fx_px == 517.3F);
  CHECK(camera.fy_px == 516.5F);
  CHECK(camera.cx_px == 318.6F);
  CHECK(camera.cy_px == 255.3F);
  CHECK(camera.depth_units_per_metre == 5000.0F);
  CHECK(camera.width_px == 640);
  CHECK(camera.height_px == 480);
  CHECK(tum_default_camera().depth_units_per_metre == 5000.0F);
}

TEST_CASE("Impossible cameras are refused with their line") {
  CHECK(camera_error("").find("camera.txt: ") == 0);
  CHECK(camera_error("#\n1 2 3\n").find("camera.txt:2: ") == 0);
  CHECK(camera_error("500 500 320 240 5000 640 480 1").find("camera.txt:1: ") == 0);
  CHECK(camera_error("500 500 320 240 5000 640 480\n500 500 320 240 5000 640 480").find("camera.txt:2: ") == 0);
  CHECK(camera_error("500 500 320 240 5000 640 99999").find("2048") != std::string::npos);
  CHECK(camera_error("500 500 320 240 5000 0 480").find("2048") != std::string::npos);
  CHECK(camera_error("500 500 320 240 5000 -640 480").find("2048") != std::string::npos);
  CHECK(camera_error("nan 500 320 240 5000 640 480").find("fx") != std::string::npos);
  CHECK(camera_error("0 500 320 240 5000 640 480").find("fx") != std::string::npos);
  CHECK(camera_error("500 inf 320 240 5000 640 480").find("fx") != std::string::npos);
  CHECK(camera_error("500 500 32000 240 5000 640 480").find("cx") != std::string::npos);
  CHECK(camera_error("500 500 320 nan 5000 640 480").find("cx") != std::string::npos);
  CHECK(camera_error("500 500 320 240 0 640 480").find("depth units") != std::string::npos);
  CHECK(camera_error("500 500 320 240 -1 640 480").find("depth units") != std::string::npos);
}

TEST_CASE("Image lists keep their order and their blanks") {
  const auto list = parse_image_list("# t f\n2.5 depth/a b.png\r\n1 ./x..y.png\n", "d").value();
  REQUIRE(list.size() == 2);
  CHECK(list[0].stamp_ns == 2'500'000'000);
  CHECK(list[0].file == "depth/a b.png");
  CHECK(list[1].file == "./x..y.png");
  CHECK(parse_image_list("", "d").value().empty());
}

TEST_CASE("File names cannot leave the folder") {
  for (const char* file : {"/etc/passwd", "..", "../a", "a/../../b", "a/..", "a\tb"}) {
    INFO(file);
    CHECK(list_error("1 good.png\n2 " + std::string(file) + "\n").find("depth.txt:2: ") == 0);
  }
  CHECK(list_error("1 " + std::string(5000, 'x')).find("depth.txt:1: ") == 0);
  CHECK(list_error(std::string("1 a\0b", 5)).find("depth.txt:1: ") == 0);
  CHECK(list_error("1").find("depth.txt:1: ") == 0);
  CHECK(list_error("a.png 1").find("depth.txt:1: ") == 0);
}

TEST_CASE("The nearest entry in time is found, and none beyond the limit") {
  const std::vector<ImageEntry> list{{100, "a"}, {200, "b"}, {300, "c"}};
  CHECK(nearest_entry(list, 200, 0) == 1);
  CHECK(nearest_entry(list, 149, 60) == 0);
  CHECK(nearest_entry(list, 150, 60) == 0);  // equally near: the earlier
  CHECK(nearest_entry(list, 151, 60) == 1);
  CHECK(nearest_entry(list, 320, 20) == 2);
  CHECK_FALSE(nearest_entry(list, 321, 20).has_value());
  CHECK(nearest_entry(list, 80, 20) == 0);
  CHECK_FALSE(nearest_entry(list, 79, 20).has_value());
  CHECK_FALSE(nearest_entry(list, 250, 49).has_value());
  CHECK_FALSE(nearest_entry({}, 250, 49).has_value());
  const TimeNs far_ns = 4'000'000'000'000'000'000;  // the earliest and the latest stamp there are
  CHECK_FALSE(nearest_entry(std::vector<ImageEntry>{{-far_ns, "a"}}, far_ns, 20).has_value());
}
