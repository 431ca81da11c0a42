// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_closer.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/sim/pose_drift.hpp"
#include "mapper/align/pose_step.hpp"
#include "tests/support/looped_drive.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

/// How far the anchors are from where the camera truly was, as far as the first is right; the worst.
double worst_anchor_m(const SubmapChain& chain, std::span<const hal::Pose> T_world_stored,
                      const test::DriveTwice& twice) {
  double worst_m = 0.0;
  for (std::size_t i = 0; i < chain.submaps().size(); ++i) {
    const Submap& submap = chain.submaps()[i];
    const hal::Pose at = hal::compose(T_world_stored[i], submap.T_stored_anchor);
    worst_m = std::max(worst_m, align::shift_of(align::difference(twice.true_pose_at(submap.anchor_ns), at)));
  }
  return worst_m;
}

}  // namespace

TEST_CASE("a room that is driven through twice with odometry that drifts is put right", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(1, 0.3));
  LoopCloser closer;
  std::uint64_t corrections = 0;
  double before_m = 0.0;
  double after_m = 0.0;
  while (drive.next_submap()) {
    if (!closer.add_submap(drive.chain())) continue;
    ++corrections;
    std::vector<hal::Pose> stored;
    for (const Submap& submap : drive.chain().submaps()) stored.push_back(submap.T_world_stored);
    before_m = worst_anchor_m(drive.chain(), stored, twice);
    after_m = worst_anchor_m(drive.chain(), closer.T_world_stored(), twice);
  }
  const CloserReport report = closer.report();
  CHECK(report.submaps == drive.chain().submaps().size());
  CHECK(report.edges == report.submaps - 1 + report.loops);
  CHECK(report.loops >= 2);
  CHECK(report.disbelieved == 0);
  CHECK(corrections == report.corrections);
  REQUIRE(corrections > 0);
  CHECK(before_m > 0.2);
  CHECK(after_m < 0.6 * before_m);
}

TEST_CASE("nothing is recognised where nothing is seen twice", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(1, 0.0));
  LoopCloser closer;
  for (int i = 0; i < 3 && drive.next_submap(); ++i) CHECK_FALSE(closer.add_submap(drive.chain()));
  CHECK(closer.report().loops == 0);
  CHECK(closer.report().corrections == 0);
  CHECK(closer.graph().edges().size() == 2);
}
