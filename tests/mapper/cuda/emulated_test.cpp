// SPDX-License-Identifier: Apache-2.0
// The kernels, run block by block in random order, against the CPU twin: the same map after every frame, whatever the
// order, for every integrator and mode.
#include "mapper/cuda/emulated.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/test_frames.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr std::array kAllKinds{IntegratorKind::projective, IntegratorKind::bresenham, IntegratorKind::dda};

MapperConfig small_config(IntegratorKind kind, float resolution_m) {
  MapperConfig config;
  config.integrator = kind;
  config.resolution_m = resolution_m;
  config.capacity = {1U << 15, 1U << 14, 1U << 15};
  return config;
}

void check_equal(const FrameReport& a, const FrameReport& b) {
  CHECK(a.valid_pixels == b.valid_pixels);
  CHECK(a.too_near_pixels == b.too_near_pixels);
  CHECK(a.far_pixels == b.far_pixels);
  CHECK(a.invalid_pixels == b.invalid_pixels);
  CHECK(a.hit_blocks == b.hit_blocks);
  CHECK(a.refused_blocks == b.refused_blocks);
}

void check_twins(const MapperConfig& config, const test::Workload& work, std::uint64_t seed) {
  Mapper cpu_twin(config, work.camera);
  test::EmulatedMapper emulated(config, work.camera, seed);
  int number = 0;
  for (const auto& [frame, pose] : work.frames) {
    INFO(to_string(config.integrator) << " " << to_string(config.mode) << " " << config.resolution_m << " m, "
                                      << work.name << " seed " << seed << " frame " << number++);
    const FrameReport expected = cpu_twin.integrate(frame, pose);
    check_equal(emulated.integrate(frame, pose), expected);
    REQUIRE(map_hash(emulated.map) == map_hash(cpu_twin.map()));
    CHECK(emulated.map.counts() == cpu_twin.map().counts());
    CHECK(emulated.map.memory().used_bytes == cpu_twin.map().memory().used_bytes);
    CHECK(emulated.twin.changed_slots().size() == cpu_twin.changed_slots().size());
  }
}

}  // namespace

TEST_CASE("kernels in random order give the CPU twin's map, on random images") {
  for (const IntegratorKind kind : kAllKinds) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      MapperConfig config = small_config(kind, seed == 2 ? 0.11F : 0.05F);
      config.steps = seed == 3 ? UpdateSteps{7, 3} : UpdateSteps{};
      config.carve_invalid = seed != 3;
      hal::CameraModel camera = test::small_camera(seed == 1 ? 100 : 60);
      camera.depth_units_per_metre = seed == 2 ? 5000.0F : 1000.0F;
      check_twins(config, {"random", camera, test::random_frames(camera, 5, seed)}, seed);
    }
  }
}

TEST_CASE("kernels give the CPU twin's map in static mode and without colour") {
  const hal::CameraModel camera = test::small_camera(80);
  MapperConfig config = small_config(IntegratorKind::projective, 0.05F);
  config.mode = MapMode::static_mode;
  check_twins(config, {"random", camera, test::random_frames(camera, 4, 11)}, 11);
  config.mode = MapMode::dynamic_mode;
  config.with_colour = false;
  check_twins(config, {"random", camera, test::random_frames(camera, 4, 12)}, 12);
}

TEST_CASE("kernels leave nothing behind in blocks that are as free as can be, for when something comes there") {
  const hal::CameraModel camera = test::small_camera(100);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config = small_config(kind, 0.04F);
    config.steps = {12, 16};  // one look frees a voxel for good, one reading marks it
    // A wall far away, seen three times, and then whatever comes, from elsewhere: boxes of frames differ.
    std::vector<test::PosedImage> frames = test::random_frames(camera, 6, 31);
    for (std::size_t i = 0; i < 3; ++i) {
      frames[i].T_world_camera = frames[0].T_world_camera;
      std::fill_n(frames[i].frame.depth.get(), camera.pixel_count(), std::uint16_t{3400});
    }
    check_twins(config, {"free, then random", camera, std::move(frames)}, 31);
  }
}

TEST_CASE("kernels give the CPU twin's map on simulated and recorded frames", "[slow]") {
  const test::Workload simulated = test::simulated_drive("furnished_room", 4, 0.5, 3.0, 160);
  REQUIRE(simulated.frames.size() == 4);
  for (const IntegratorKind kind : kAllKinds) {
    check_twins(small_config(kind, 0.05F), simulated, 21);
    check_twins(small_config(kind, 0.03F), test::thinned_recording("rgbd_tum_fr1_rpy", 3, 5, 4), 22);
    check_twins(small_config(kind, 0.05F), test::thinned_recording("rgbd_3dmatch_couch_5", 3, 1, 4), 23);
  }
}
