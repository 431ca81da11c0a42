// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/looped_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/looped_drive.hpp"
#include "tests/support/memory_page_file.hpp"
#include "tests/support/trajectory_error.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

struct Run {
  std::unique_ptr<Mapper> mapper;
  std::vector<hal::StampedPose> live;
  std::vector<hal::StampedPose> corrected;
  CloserReport report;
  int corrections = 0;
  std::string hash;  ///< of all of the map
  std::uint32_t most_blocks = 0;
  ViewWindowCounts window;
  ShelfCounts shelf;
};

Run run(const test::DriveTwice& twice, const hal::PoseDrift& drift, const LoopedOptions& options,
        std::unique_ptr<PageFile> pages = nullptr) {
  const std::vector<hal::StampedPose> odometry = hal::drifted(twice.truth(), drift);
  Run r;
  r.mapper = std::make_unique<Mapper>(test::looped_drive_config(), twice.work.camera);
  LoopedMap looped(r.mapper->map(), twice.work.camera, options, std::move(pages));
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const hal::Frame& frame = twice.work.frames[i].frame;
    const hal::Pose pose = looped.align(frame, odometry[i].T_world_camera).T_world_camera;
    looped.prepare();
    (void)r.mapper->integrate(frame, pose);
    r.most_blocks = std::max(r.most_blocks, r.mapper->map().block_count());
    r.live.push_back({frame.stamp_ns, pose});
    r.corrections += looped.add(frame, r.mapper->changed_slots()) ? 1 : 0;
  }
  r.corrections += looped.finish() ? 1 : 0;
  for (const hal::StampedPose& pose : r.live) {
    r.corrected.push_back({pose.stamp_ns, looped.corrected(pose.stamp_ns, pose.T_world_camera)});
  }
  r.report = looped.report();
  r.hash = looped.is_windowed() ? map_hash(looped.whole_map()) : map_hash(r.mapper->map());
  if (looped.is_windowed()) {
    r.window = looped.window().counts();
    r.shelf = looped.shelf().counts();
  }
  return r;
}

}  // namespace

TEST_CASE("a corridor that is gone round and begun again is put right by its loops", "[slow]") {
  test::DriveTwice twice = test::twice_through("corridor", 300);
  twice.work.frames.resize(420);
  const Run a = run(twice, hal::robot_drift(2), {});
  CHECK(a.report.loops >= 2);
  CHECK(a.report.refused_blocks == 0);
  CHECK(a.report.memory_bytes > 0);
  REQUIRE(a.corrections > 0);
  CHECK(static_cast<std::uint64_t>(a.corrections) == a.report.corrections);
  const double live_m = test::trajectory_error(twice.truth(), a.live).ate_m;
  const double corrected_m = test::trajectory_error(twice.truth(), a.corrected).ate_m;
  CHECK(corrected_m < 0.6 * live_m);
}

TEST_CASE("a map with a window around the camera is corrected as one without, to the bit", "[slow][window]") {
  test::DriveTwice twice = test::twice_through("corridor", 300);
  twice.work.frames.resize(325);  // round once, and past where it began
  LoopedOptions options;
  options.window.near_m = test::looped_drive_config().near_m;
  options.window.far_m = test::looped_drive_config().far_m;
  options.window.radius_m = 0.0;  // as small as can be
  const Run plain = run(twice, hal::robot_drift(2), options);
  const Run paged = run(twice, hal::robot_drift(2), options, std::make_unique<tests::MemoryPageFile>());
  REQUIRE(plain.corrections > 0);
  CHECK(paged.corrections == plain.corrections);
  CHECK(paged.report.loops == plain.report.loops);
  CHECK(paged.hash == plain.hash);
  REQUIRE(paged.live.size() == plain.live.size());
  const auto is_at = [](const hal::StampedPose& a, const hal::StampedPose& b) {
    return a.T_world_camera.translation_m == b.T_world_camera.translation_m &&
           a.T_world_camera.rotation_xyzw == b.T_world_camera.rotation_xyzw;
  };
  CHECK(std::equal(paged.live.begin(), paged.live.end(), plain.live.begin(), is_at));
  CHECK(std::equal(paged.corrected.begin(), paged.corrected.end(), plain.corrected.begin(), is_at));
  CHECK(paged.report.refused_blocks == 0);
  CHECK(paged.most_blocks < plain.most_blocks * 2 / 3);
  CHECK(paged.window.regions_out > 10);
  CHECK(paged.window.regions_in > 10);
  CHECK(paged.shelf.put_away > 5);
  CHECK(paged.shelf.fetched > 5);
  CHECK(paged.shelf.failed_stores + paged.shelf.failed_loads == 0);
}

TEST_CASE("the same frames and poses are corrected to the same map each time", "[slow]") {
  const test::DriveTwice twice = test::twice_through("furnished_room", 60);
  LoopedOptions options;
  options.align.least_matched = 2.0;  // no frame ever matches so much: poses are odometry's
  const Run a = run(twice, hal::robot_drift(3), options);
  const Run b = run(twice, hal::robot_drift(3), options);
  CHECK(a.corrections > 0);
  CHECK(map_hash(a.mapper->map()) == map_hash(b.mapper->map()));
}

TEST_CASE("a map that is right is left as it is", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  LoopedOptions options;
  options.align.least_matched = 2.0;  // no frame ever matches so much: poses are odometry's
  const Run r = run(twice, hal::robot_drift(1, 0.0), options);
  CHECK(r.report.loops >= 2);
  CHECK(r.corrections == 0);
  for (std::size_t i = 0; i < r.live.size(); ++i) {
    REQUIRE(r.live[i].T_world_camera.translation_m == r.corrected[i].T_world_camera.translation_m);
  }
}
