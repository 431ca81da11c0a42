// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/tum_folder.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;
using g3d::test::TempFolder;
using g3d::test::write_plain;

TEST_CASE("Colour goes with the depth image nearest in time, within 20 ms") {
  const TempFolder folder;
  write_plain(folder / "camera.txt", "500 501 160 120 1000 320 240\n");
  write_plain(folder / "depth.txt", "1.000 depth/1.png\n1.033 depth/2.png\n1.100 depth/3.png\n");
  // Not sorted, which the association must not need.
  write_plain(folder / "rgb.txt", "1.0305 rgb/b.jpg\n0.985 rgb/a.jpg\n1.021 rgb/c.jpg\n1.1201 rgb/d.jpg\n");
  const TumFolder log = TumFolder::open(folder.path()).value();
  CHECK(log.warnings.empty());
  CHECK(log.camera.fy_px == 501.0F);
  REQUIRE(log.frames.size() == 3);
  CHECK(log.frames[0].stamp_ns == 1'000'000'000);
  CHECK(log.frames[0].depth_path == folder.path() + "/depth/1.png");
  CHECK(log.frames[0].colour_path == folder.path() + "/rgb/a.jpg");
  CHECK(log.frames[1].colour_path == folder.path() + "/rgb/b.jpg");
  CHECK(log.frames[2].colour_path.empty());
}

TEST_CASE("Without camera.txt and rgb.txt there are defaults and warnings") {
  const TempFolder folder;
  write_plain(folder / "depth.txt", "");
  const TumFolder log = TumFolder::open(folder.path()).value();
  CHECK(log.frames.empty());
  CHECK(log.camera.fx_px == 525.0F);
  CHECK(log.camera.depth_units_per_metre == 5000.0F);
  REQUIRE(log.warnings.size() == 2);
  CHECK(log.warnings[0].find("camera.txt: missing") != std::string::npos);
}

TEST_CASE("What is there but broken is an error, with its place") {
  const TempFolder folder;
  const auto error = [&] { return TumFolder::open(folder.path()).error(); };
  CHECK(error().reason == Reason::not_found);
  CHECK(error().text.find("depth.txt is missing") != std::string::npos);
  write_plain(folder / "depth.txt", "1 a.png\noops\n");
  CHECK(error().text.find("/depth.txt:2: ") != std::string::npos);
  write_plain(folder / "depth.txt", "1 a.png\n");
  write_plain(folder / "camera.txt", "1 2 3\n");
  CHECK(error().text.find("/camera.txt:1: ") != std::string::npos);
  write_plain(folder / "camera.txt", "500 500 320 240 5000 640 480\n");
  write_plain(folder / "rgb.txt", "1 /etc/passwd\n");
  CHECK(error().text.find("/rgb.txt:1: ") != std::string::npos);
  write_plain(folder / "rgb.txt", "");
  CHECK(TumFolder::open(folder.path()).ok());
  CHECK(TumFolder::open(folder.path() + "/none").error().reason == Reason::not_found);
}

TEST_CASE("trajectory.tum is preferred to groundtruth.txt") {
  const TempFolder folder;
  CHECK(find_trajectory(folder.path()).error().reason == Reason::not_found);
  write_plain(folder / "groundtruth.txt", "");
  CHECK(find_trajectory(folder.path()).value() == folder.path() + "/groundtruth.txt");
  write_plain(folder / "trajectory.tum", "");
  CHECK(find_trajectory(folder.path()).value() == folder.path() + "/trajectory.tum");
}
