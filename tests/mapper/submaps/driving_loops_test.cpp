// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/driving_loops.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/looped_drive.hpp"
#include "tests/support/trajectory_error.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

struct Run {
  std::unique_ptr<Mapper> mapper;
  std::vector<hal::StampedPose> corrected;
  CloserReport report;
  int begun = 0;
  int parts = 0;
  bool leaves_out_only_moves = true;
  // When the map had moved for the first time:
  std::string moved_hash;
  std::size_t moved_at_frame = 0;
  int moved_parts = 0;
};

enum class Until : bool { first_move, end };

/// A robot that does not stop for moves of the map: some of its frames are not mapped.
Run run(const test::DriveTwice& twice, const hal::PoseDrift& drift, const DrivingOptions& options, Until until) {
  const std::vector<hal::StampedPose> odometry = hal::drifted(twice.truth(), drift);
  Run r;
  r.mapper = std::make_unique<Mapper>(test::looped_drive_config(), twice.work.camera);
  align::Aligner aligner({}, twice.work.camera);
  DrivingLoops loops(r.mapper->map(), twice.work.camera, options);
  std::vector<hal::StampedPose> live;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const hal::Frame& frame = twice.work.frames[i].frame;
    loops.wait_if_due(frame.stamp_ns);
    if (loops.is_moving()) {
      (void)loops.move_on();
      ++r.parts;
      if (!loops.is_moving()) {
        aligner.correct(loops.move().newest(), [&](hal::TimeNs born_ns) { return loops.move().at(born_ns); });
        if (r.moved_hash.empty()) {
          r.moved_hash = map_hash(r.mapper->map());
          r.moved_at_frame = i;
          r.moved_parts = r.parts;
          if (until == Until::first_move) break;
        }
      }
      continue;
    }
    if (loops.begins_to_move(frame.stamp_ns)) {
      ++r.begun;
      r.leaves_out_only_moves = r.leaves_out_only_moves && loops.is_moving();
      continue;
    }
    const align::AlignResult placed = aligner.align(frame, odometry[i].T_world_camera);
    (void)r.mapper->integrate(frame, placed.T_world_camera);
    live.push_back({frame.stamp_ns, placed.T_world_camera});
    loops.add(frame, placed, aligner.samples(), r.mapper->changed_slots());
  }
  loops.finish();
  for (const hal::StampedPose& pose : live) {
    r.corrected.push_back({pose.stamp_ns, loops.corrected(pose.stamp_ns, pose.T_world_camera)});
  }
  r.report = loops.report();
  return r;
}

}  // namespace

TEST_CASE("a robot's map is put right while it goes on, the same way every time", "[slow]") {
  test::DriveTwice twice = test::twice_through("corridor", 300);
  twice.work.frames.resize(420);  // round once, and on through what was seen before
  DrivingOptions options;
  options.is_lockstep = true;
  options.most_blocks_per_frame = 1000;
  const Run a = run(twice, hal::robot_drift(2), options, Until::end);
  CHECK(a.report.loops >= 2);
  CHECK(a.report.corrections > 0);
  CHECK(a.report.refused_blocks == 0);
  CHECK(a.leaves_out_only_moves);
  CHECK(a.begun > 0);
  CHECK(a.parts >= 2 * a.begun);
  std::vector<hal::StampedPose> truth;
  for (const hal::StampedPose& pose : a.corrected) {
    truth.push_back({pose.stamp_ns, twice.true_pose_at(pose.stamp_ns)});
  }
  const std::vector<hal::StampedPose> unaligned = hal::drifted(twice.truth(), hal::robot_drift(2));
  CHECK(test::trajectory_error(truth, a.corrected).ate_m <
        0.2 * test::trajectory_error(twice.truth(), unaligned).ate_m);
  const Run b = run(twice, hal::robot_drift(2), options, Until::first_move);
  REQUIRE(a.moved_parts > 0);
  CHECK(b.moved_hash == a.moved_hash);
  CHECK(b.moved_at_frame == a.moved_at_frame);
  CHECK(b.moved_parts == a.moved_parts);
}
