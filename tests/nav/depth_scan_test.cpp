// SPDX-License-Identifier: Apache-2.0
#include "nav/depth_scan.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"

using namespace g3d;
using nav::DepthScan;

namespace {

const hal::CameraModel kCamera = hal::scaled_kinect(160, 120);

/// What a robot at the origin, looking along +x, sees of these solids.
DepthScan scan_of(const std::string& solids, const hal::CameraModel& camera = kCamera,
                  const hal::Pose& T_base_camera = hal::forward_camera()) {
  hal::SimBuildingOptions options;
  options.camera = camera;
  options.noise = solids.find("dark") != std::string::npos;  // it takes the noise to lose readings
  options.robots.emplace_back().T_base_camera = T_base_camera;
  hal::SimBuilding building(hal::parse_world("floor 0 0 0 20 20 0.1\n" + solids, "w").value(), options);
  hal::Frame frame = hal::make_frame(camera);
  building.render(0, frame);
  nav::DepthScanConfig config;
  config.T_base_camera = T_base_camera;
  DepthScan scan(config);
  scan.look(frame, camera);
  return scan;
}

const DepthScan::Ray& middle_of(const DepthScan& scan) { return scan.rays()[DepthScan::kRays / 2]; }

}  // namespace

TEST_CASE("Over free floor the rays go on to the end of their range and hit nothing", "[nav][depth_scan]") {
  const DepthScan scan = scan_of("");
  for (const DepthScan::Ray& ray : scan.rays()) {
    CHECK_FALSE(ray.has_hit);
    CHECK(ray.through_m == Approx(3.0));
  }
  CHECK(scan.rays().front().bearing_rad == Approx(0.54).margin(0.03));
  CHECK(scan.rays().back().bearing_rad == Approx(-0.54).margin(0.03));
}

TEST_CASE("A ray ends where something as high as the body begins, also nearer than the map trusts",
          "[nav][depth_scan]") {
  for (const double x_m : {0.55, 0.9, 2.2}) {
    const DepthScan scan = scan_of("box " + std::to_string(x_m + 0.1) + " 0 0  0.2 0.4 1.8\n");
    const DepthScan::Ray& ray = middle_of(scan);
    REQUIRE(ray.has_hit);
    CHECK(ray.hit_x_m == Approx(x_m).margin(0.01));
    CHECK(std::fabs(ray.hit_y_m) < 0.04);
    CHECK(ray.through_m == Approx(x_m).margin(0.01));
  }
}

TEST_CASE("What the robot drives under and what lies flat on the floor is no hit", "[nav][depth_scan]") {
  CHECK_FALSE(middle_of(scan_of("box 1.5 0 0.65  0.5 1 0.5\n")).has_hit);
  CHECK_FALSE(middle_of(scan_of("box 1.8 0 0  0.5 1 0.05\n")).has_hit);
  CHECK(middle_of(scan_of("box 1.5 0 0.45  0.5 1 0.5\n")).has_hit);
  CHECK_FALSE(middle_of(scan_of("box 4 0 0  0.5 1 1\n")).has_hit);  // it has time
}

TEST_CASE("The floor is followed from the image's lower edge to where it ends or is hidden", "[nav][depth_scan]") {
  CHECK(middle_of(scan_of("")).floor_to_m > 3.0);
  CHECK(middle_of(scan_of("box 1.6 0 0  0.2 1 1\n")).floor_to_m == Approx(1.5).margin(0.06));
  CHECK(middle_of(scan_of("box 1.6 0 0  0.2 1 0.3 dark\n")).floor_to_m == Approx(1.5).margin(0.08));
  CHECK(middle_of(scan_of("box 1.0 0 0  0.2 1 0.3 dark\n")).floor_to_m == 0.0);  // beyond it the floor goes on
}

TEST_CASE("Without a reading nothing is said", "[nav][depth_scan]") {
  hal::Frame frame = hal::make_frame(kCamera);
  DepthScan scan({});
  scan.look(frame, kCamera);
  for (const DepthScan::Ray& ray : scan.rays()) {
    CHECK_FALSE(ray.has_hit);
    CHECK(ray.through_m == 0.0);
  }
}

TEST_CASE("One reading alone is a speckle, two that agree are not", "[nav][depth_scan]") {
  hal::Frame frame = hal::make_frame(kCamera);
  const auto set = [&](int v, std::uint16_t raw) {
    for (int u = 0; u < kCamera.width_px; ++u) frame.depth[static_cast<std::size_t>(v * kCamera.width_px + u)] = raw;
  };
  for (int v = 0; v < kCamera.height_px; ++v) set(v, v < 70 ? 2500 : 0);
  set(61, 1000);
  DepthScan scan({});
  scan.look(frame, kCamera);
  CHECK(middle_of(scan).hit_x_m == Approx(2.5).margin(0.01));
  set(63, 1030);
  scan.look(frame, kCamera);
  CHECK(middle_of(scan).hit_x_m == Approx(1.0).margin(0.04));
}

TEST_CASE("The mount counts: an offset camera that looks down sees the same thing in the same place",
          "[nav][depth_scan]") {
  const hal::Pose looking_down = hal::look_at({0.08, 0.03, 0.55}, {1.08, 0.03, 0.35});
  const DepthScan scan = scan_of("box 1.3 0 0  0.2 3 1.0\n", kCamera, looking_down);
  for (const DepthScan::Ray& ray : scan.rays()) {
    REQUIRE(ray.has_hit);
    CHECK(ray.hit_x_m == Approx(1.2).margin(0.02));
  }
  CHECK(scan.eye_x_m() == Approx(0.08));
  CHECK(scan.eye_y_m() == Approx(0.03));
}

TEST_CASE("Larger images give the same fan", "[nav][depth_scan]") {
  const std::string solids = "box 1.3 0.2 0  0.2 0.4 1.0\npole 2 -0.4 0 0.08 1\n";
  const DepthScan small = scan_of(solids);
  const DepthScan large = scan_of(solids, hal::scaled_kinect(640, 480));
  int different = 0;
  for (std::size_t i = 0; i < DepthScan::kRays; ++i) {
    CHECK(small.rays()[i].bearing_rad == Approx(large.rays()[i].bearing_rad).margin(0.01));
    different += std::fabs(small.rays()[i].through_m - large.rays()[i].through_m) > 0.05 ? 1 : 0;
  }
  CHECK(different <= 3);  // at edges
}
