// SPDX-License-Identifier: Apache-2.0
// The integrators that walk rays against one ray at a time, and the exact one against OctoMap itself.
#include "mapper/cpu/ray_grid.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/octomap_twin.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

void check_against_plain(const MapperConfig& config, const test::Workload& work) {
  Mapper mapper(config, work.camera);
  test::PlainMapper plain(config, work.camera);
  int number = 0;
  for (const auto& [frame, pose] : work.frames) {
    mapper.integrate(frame, pose);
    plain.integrate(frame, pose);
    INFO(to_string(config.integrator) << " " << config.resolution_m << " m, " << work.name << " frame " << number++);
    REQUIRE(plain.differences(mapper.map()) == "");
  }
  CHECK(plain.hash() == map_hash(mapper.map()));
}

/// Both maps from the same points, pixels without a reading left out of both.
test::Agreement agreement_with_octomap(const test::Workload& work, float resolution_m) {
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.integrator = IntegratorKind::dda;
  config.carve_invalid = false;
  Mapper mapper(config, work.camera);
  test::OctomapTwin octomap(resolution_m);
  for (const auto& [frame, pose] : work.frames) {
    mapper.integrate(frame, pose);
    octomap.integrate(test::ray_list(work.camera, frame.depth.get(), pose));
  }
  return octomap.compare(mapper.map());
}

void check_faithful(const test::Workload& work, float resolution_m) {
  const test::Agreement a = agreement_with_octomap(work, resolution_m);
  INFO(work.name << " at " << resolution_m << " m: " << test::describe(a));
  CHECK(a.known > 10000);
  CHECK(a.share() >= 0.995);
  // What differs is what rays graze: nothing that a ray crosses squarely may be missing on one side.
  CHECK(a.grazed + a.deep == a.only_ours + a.only_theirs + a.other_state);
  CHECK(static_cast<double>(a.deep) <= 0.0005 * static_cast<double>(a.known));
}

}  // namespace

TEST_CASE("rays give the map of the plain walk, bit by bit, on random images", "[slow]") {
  for (const auto kind : {IntegratorKind::dda, IntegratorKind::bresenham}) {
    for (const float resolution_m : {0.05F, 0.13F}) {
      for (std::uint64_t seed = 10; seed < 13; ++seed) {
        MapperConfig config;
        config.integrator = kind;
        config.resolution_m = resolution_m;
        config.threads = seed % 2 == 0 ? 1 : 2;
        config.steps = seed == 12 ? UpdateSteps{7, 3} : UpdateSteps{};
        config.carve_invalid = seed != 11;
        const hal::CameraModel camera = test::small_camera(60);
        check_against_plain(config, {"random", camera, test::random_frames(camera, 8, seed)});
      }
    }
  }
}

TEST_CASE("rays give the map of the plain walk on simulated and recorded frames") {
  for (const auto kind : {IntegratorKind::dda, IntegratorKind::bresenham}) {
    MapperConfig config;
    config.integrator = kind;
    check_against_plain(config, test::thinned(test::simulated_drive("furnished_room", 4, 0.4, 3.0, 160), 1, 2));
    check_against_plain(config, test::thinned_recording("rgbd_tum_fr1_rpy", 3, 5, 8));
  }
}

TEST_CASE("what strays beyond the image's border is not left for a later frame", "[slow]") {
  MapperConfig config;
  config.integrator = IntegratorKind::bresenham;
  check_against_plain(config, test::simulated_drive("furnished_room", 2, 1.5, 21.0));
}

TEST_CASE("the exact rays agree with OctoMap on a simulated drive", "[long]") {
  const test::Workload work = test::simulated_drive("furnished_room", 6, 0.2, 2.0, 160);
  check_faithful(work, 0.05F);
  check_faithful(test::thinned(work, 3, 1), 0.02F);
}

TEST_CASE("the exact rays agree with OctoMap on real frames", "[long]") {
  for (const char* name : {"rgbd_tum_fr1_rpy", "rgbd_3dmatch_couch_5"}) {
    const test::Workload work = test::thinned_recording(name, 3, 3, 8);
    if (work.frames.empty()) continue;  // the recording is not here
    check_faithful(work, 0.05F);
    check_faithful(test::thinned(work, 2, 1), 0.02F);
  }
}

TEST_CASE("the exact rays agree with OctoMap over long runs of whole images", "[.slow]") {
  check_faithful(test::simulated_drive("furnished_room", 40, 0.1), 0.05F);
  check_faithful(test::simulated_drive("furnished_room", 15, 0.1), 0.02F);
  for (const char* name : {"rgbd_tum_fr1_rpy", "rgbd_3dmatch_couch_5"}) {
    const test::Workload work = test::thinned_recording(name, 30, 1, 1);
    if (work.frames.empty()) continue;
    check_faithful(work, 0.05F);
    check_faithful(work, 0.02F);
  }
}
