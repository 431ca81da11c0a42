// SPDX-License-Identifier: Apache-2.0
// Voxels that look for rays against rays that walk through voxels: the same map to the last bit, above all where rays
// and voxels meet in ties. That the walk is right is shown in ray_grid_test.cpp.
#include "mapper/cpu/exact_rays.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "mapper/cpu/ray_grid.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/free_space_run.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

MapperConfig config_at(float resolution_m) {
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.integrator = IntegratorKind::dda;
  config.capacity = capacity_for_bytes(std::size_t{128} << 20);
  return config;
}

SensorGeometry sensor_of(const MapperConfig& config, const hal::CameraModel& camera) {
  return {camera, config.resolution_m, config.near_m, config.far_m};
}

std::string searched(const MapperConfig& config, const test::Workload& work, const Kernels& kernels = best_kernels()) {
  const SensorGeometry sensor = sensor_of(config, work.camera);
  ExactRays rays(sensor);
  return test::hash_of_run(rays, kernels, config, work);
}

std::string walked(const MapperConfig& config, const test::Workload& work) {
  const SensorGeometry sensor = sensor_of(config, work.camera);
  RayGrid rays(sensor, IntegratorKind::dda);
  return test::hash_of_run(rays, best_kernels(), config, work);
}

/// Moves the camera onto the border between voxels along the axes that `axes` names by bits.
void put_on_border(hal::Pose& pose, unsigned axes, double resolution_m) {
  for (std::size_t a = 0; a < 3; ++a) {
    double& x = pose.translation_m[a];
    if ((axes >> a & 1U) != 0) x = std::round(x / resolution_m) * resolution_m;
  }
}

}  // namespace

TEST_CASE("searched rays give the map of the plain walk, bit by bit") {
  const hal::CameraModel camera = test::small_camera(60);
  for (const float resolution_m : {0.05F, 0.13F}) {
    for (std::uint64_t seed = 50; seed < 52; ++seed) {
      MapperConfig config = config_at(resolution_m);
      config.carve_invalid = seed != 51;
      const test::Workload work{"random", camera, test::random_frames(camera, 4, seed)};
      test::PlainMapper plain(config, camera);
      for (const auto& [frame, pose] : work.frames) plain.integrate(frame, pose);
      CHECK(searched(config, work) == plain.hash());
    }
  }
}

TEST_CASE("searched rays give the map of walked ones, wherever the camera is and however large voxels appear",
          "[slow]") {
  for (const float resolution_m : {0.03F, 0.05F, 0.11F, 0.5F}) {
    for (const int width_px : {40, 120}) {
      hal::CameraModel camera = test::small_camera(width_px);
      camera.depth_units_per_metre = width_px == 40 ? 5000.0F : 1000.0F;
      for (std::uint64_t seed = 60; seed < 64; ++seed) {
        MapperConfig config = config_at(resolution_m);
        config.steps = seed == 61 ? UpdateSteps{7, 3} : UpdateSteps{};
        config.mask_depth_m = seed == 62 ? 0.4F : 3.0F;
        test::Workload work{"random", camera, test::random_frames(camera, 3, seed)};
        if (seed == 63) {
          for (auto& image : work.frames) image.T_world_camera.translation_m[1] += 30000.0 * double{resolution_m};
        }
        INFO(resolution_m << " m, " << width_px << " pixels, seed " << seed);
        CHECK(searched(config, work) == walked(config, work));
      }
    }
  }
}

TEST_CASE("where the camera lies on the border of voxels all rays are ties, and are decided as the walk does",
          "[long]") {
  const hal::CameraModel camera = test::small_camera(120);
  const double half = std::sqrt(0.5);
  const std::array<std::array<double, 4>, 4> square{
      {{0, 0, 0, 1}, {half, 0, 0, half}, {0, half, 0, half}, {0.5, 0.5, 0.5, 0.5}}};
  for (const double resolution_m : {0.05, 0.0625}) {
    for (unsigned axes = 1; axes < 8; ++axes) {
      const MapperConfig config = config_at(static_cast<float>(resolution_m));
      test::Workload work{"on a border", camera, test::random_frames(camera, 4, 70 + axes)};
      for (std::size_t i = 0; i < work.frames.size(); ++i) {
        hal::Pose& pose = work.frames[i].T_world_camera;
        put_on_border(pose, axes, resolution_m);
        if (i % 2 == 1) pose.rotation_xyzw = square[(axes + i / 2) % square.size()];  // rays along planes of the grid
      }
      INFO(resolution_m << " m, axes " << axes);
      CHECK(searched(config, work) == walked(config, work));
    }
  }
}

TEST_CASE("searched rays give the map of walked ones on a simulated drive and on recordings", "[long]") {
  const test::Workload drive = test::simulated_drive("furnished_room", 6, 1.3, 0.0, 320);
  CHECK(searched(config_at(0.05F), drive) == walked(config_at(0.05F), drive));
  CHECK(searched(config_at(0.02F), test::thinned(drive, 3, 2)) == walked(config_at(0.02F), test::thinned(drive, 3, 2)));
  for (const char* name : {"rgbd_tum_fr1_rpy", "rgbd_3dmatch_couch_5"}) {
    const test::Workload work = test::thinned_recording(name, 3, 5, 3);
    if (work.frames.empty()) continue;  // the recording is not here
    CHECK(searched(config_at(0.05F), work) == walked(config_at(0.05F), work));
  }
}

TEST_CASE("searched rays give the map of walked ones on whole images", "[.slow]") {
  const test::Workload drive = test::simulated_drive("furnished_room", 20, 3.0, 0.0, 640);
  for (const float resolution_m : {0.05F, 0.02F, 0.01F}) {
    MapperConfig config = config_at(resolution_m);
    config.capacity = capacity_for_bytes(std::size_t{1500} << 20);
    CHECK(searched(config, drive) == walked(config, drive));
    for (const char* name : {"rgbd_tum_fr1_rpy", "rgbd_3dmatch_couch_5"}) {
      const test::Workload work = test::thinned_recording(name, 10, 3, 1);
      if (!work.frames.empty()) CHECK(searched(config, work) == walked(config, work));
    }
  }
}

TEST_CASE("every set of kernels searches alike, for any number of threads", "[threads]") {
  const hal::CameraModel camera = test::small_camera(92);
  const test::Workload work{"random", camera, test::random_frames(camera, 4, 80)};
  MapperConfig config = config_at(0.07F);
  const std::string expected = walked(config, work);
  for (const Kernels* kernels : test::kernel_variants()) {
    for (const int threads : {1, 2, 3}) {
      config.threads = threads;
      INFO(kernels->name << ", " << threads << " threads");
      CHECK(searched(config, work, *kernels) == expected);
    }
  }
}

TEST_CASE("rays are searched where voxels are large enough, and the mapper's map does not depend on it", "[long]") {
  const auto pays = [](int width_px, float resolution_m) {
    return ExactRays::pays(sensor_of(config_at(resolution_m), test::small_camera(width_px)));
  };
  CHECK(pays(640, 0.05F));
  CHECK(pays(640, 0.02F));
  CHECK_FALSE(pays(640, 0.01F));
  CHECK(pays(320, 0.05F));
  CHECK_FALSE(pays(160, 0.05F));
  const test::Workload drive = test::simulated_drive("furnished_room", 3, 2.0, 5.0, 320);
  for (const float resolution_m : {0.05F, 0.025F}) {
    const MapperConfig config = config_at(resolution_m);
    Mapper mapper(config, drive.camera);
    for (const auto& [frame, pose] : drive.frames) mapper.integrate(frame, pose);
    CHECK(map_hash(mapper.map()) == walked(config, drive));
    CHECK(map_hash(mapper.map()) == searched(config, drive));
  }
}
