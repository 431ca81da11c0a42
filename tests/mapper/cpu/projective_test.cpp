// SPDX-License-Identifier: Apache-2.0
// The block-wise projective integrator against the same question asked of every voxel, and against exact rays.
#include "mapper/cpu/projective.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/free_space_run.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

void check_against_plain(const MapperConfig& config, const test::Workload& work) {
  Mapper mapper(config, work.camera);
  test::PlainMapper plain(config, work.camera);
  int number = 0;
  for (const auto& [frame, pose] : work.frames) {
    mapper.integrate(frame, pose);
    plain.integrate(frame, pose);
    INFO(config.resolution_m << " m, " << work.name << " frame " << number++);
    REQUIRE(plain.differences(mapper.map()) == "");
  }
  CHECK(plain.hash() == map_hash(mapper.map()));
}

}  // namespace

TEST_CASE("projection block by block gives the map of projection voxel by voxel, on random images", "[long]") {
  for (const float resolution_m : {0.05F, 0.11F}) {
    for (std::uint64_t seed = 30; seed < 34; ++seed) {
      MapperConfig config;
      config.resolution_m = resolution_m;
      config.threads = seed % 2 == 0 ? 1 : 3;
      config.steps = seed == 33 ? UpdateSteps{7, 3} : UpdateSteps{};
      config.carve_invalid = seed != 31;
      hal::CameraModel camera = test::small_camera(60);
      camera.depth_units_per_metre = seed == 32 ? 5000.0F : 1000.0F;
      check_against_plain(config, {"random", camera, test::random_frames(camera, resolution_m < 0.1F ? 4 : 8, seed)});
    }
  }
}

TEST_CASE("projection gives the plain map on simulated and recorded frames", "[long]") {
  const test::Workload simulated = test::simulated_drive("furnished_room", 4, 0.5, 3.0, 160);
  REQUIRE(simulated.frames.size() == 4);
  MapperConfig config;
  check_against_plain(config, simulated);
  check_against_plain(config, test::thinned_recording("rgbd_tum_fr1_rpy", 2, 5, 6));
  check_against_plain(config, test::thinned_recording("rgbd_3dmatch_couch_5", 2, 5, 6));
  config.resolution_m = 0.03F;
  check_against_plain(config, test::thinned(simulated, 3, 2));
}

TEST_CASE("projection gives the plain map on whole images at fine resolution", "[.slow]") {
  MapperConfig config;
  config.resolution_m = 0.02F;
  check_against_plain(config, test::simulated_drive("furnished_room", 3, 2.0, 3.0, 640));
  check_against_plain(config, test::thinned_recording("rgbd_tum_fr1_rpy", 2, 20, 1));
}

TEST_CASE("every set of kernels gives the same map, for any number of threads", "[threads]") {
  const hal::CameraModel camera = test::small_camera(92);
  const test::Workload work{"random", camera, test::random_frames(camera, 6, 40)};
  MapperConfig config;
  config.resolution_m = 0.07F;
  Mapper mapper(config, camera);
  for (const auto& [frame, pose] : work.frames) mapper.integrate(frame, pose);
  const std::string expected = map_hash(mapper.map());
  for (const Kernels* kernels : test::kernel_variants()) {
    for (const int threads : {1, 2, 3}) {
      config.threads = threads;
      Projective projective(SensorGeometry(camera, config.resolution_m, config.near_m, config.far_m));
      INFO(kernels->name << ", " << threads << " threads");
      CHECK(test::hash_of_run(projective, *kernels, config, work) == expected);
    }
  }
}

TEST_CASE("projection and exact rays know nearly the same") {
  const test::Workload work = test::simulated_drive("furnished_room", 12, 0.15, 4.0, 320);
  MapperConfig config;
  config.integrator = IntegratorKind::dda;
  Mapper rays(config, work.camera);
  config.integrator = IntegratorKind::projective;
  Mapper projected(config, work.camera);
  for (const auto& [frame, pose] : work.frames) {
    rays.integrate(frame, pose);
    projected.integrate(frame, pose);
  }
  std::vector<BlockKey> keys = rays.map().sorted_keys();
  for (const BlockKey key : projected.map().sorted_keys()) keys.push_back(key);
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  double known = 0;
  double differ = 0;
  double occupied = 0;
  double lost = 0;
  for (const BlockKey key : keys) {
    for (MCode place = 0; place < kBlockVoxels; ++place) {
      const State a = state_of(rays.map().at((key << kBlockShift) | place));
      const State b = state_of(projected.map().at((key << kBlockShift) | place));
      known += a != State::unknown || b != State::unknown ? 1 : 0;
      differ += a != b ? 1 : 0;
      occupied += a == State::occupied ? 1 : 0;
      lost += a == State::occupied && b != State::occupied ? 1 : 0;
    }
  }
  INFO(differ << " of " << known << " known voxels differ, " << lost << " of " << occupied
              << " occupied ones are lost");
  CHECK(known > 100000);
  CHECK(differ <= 0.03 * known);
  CHECK(lost <= 0.005 * occupied);
}
