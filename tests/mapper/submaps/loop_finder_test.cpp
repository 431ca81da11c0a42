// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_finder.hpp"

#include <catch2/catch.hpp>

#include "mapper/align/pose_step.hpp"
#include "tests/support/looped_drive.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

struct Found {
  std::size_t loops = 0;
  double worst_m = 0.0;     ///< of a loop
  double farthest_m = 0.0;  ///< of what the chain believed
};

Found find_all(LoopFinder& finder, const test::DriveTwice& twice, test::UnalignedDrive& drive) {
  Found result;
  while (drive.next_submap()) {
    const auto submaps = drive.chain().submaps();
    for (const Loop& loop : finder.find(drive.chain())) {
      ++result.loops;
      CHECK(loop.to == submaps.size() - 1);
      CHECK(loop.from + FinderOptions{}.least_age <= loop.to);
      CHECK(loop.hold > 0.02);
      CHECK(loop.hold <= 0.5);
      const auto between = [](const hal::Pose& a, const hal::Pose& b) { return hal::compose(hal::inverse(a), b); };
      const hal::Pose right =
          between(twice.true_pose_at(submaps[loop.from].anchor_ns), twice.true_pose_at(submaps[loop.to].anchor_ns));
      const hal::Pose believed = between(submaps[loop.from].T_world_anchor(), submaps[loop.to].T_world_anchor());
      result.worst_m = std::max(result.worst_m, align::shift_of(align::difference(right, loop.T_from_to)));
      result.farthest_m = std::max(result.farthest_m, align::shift_of(align::difference(right, believed)));
    }
  }
  return result;
}

}  // namespace

TEST_CASE("what is seen again is found where it truly is, however far odometry is off", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(2, 0.3));
  LoopFinder finder;
  const Found found = find_all(finder, twice, drive);
  CHECK(found.loops >= 2);
  CHECK(finder.report().found == found.loops);
  CHECK(finder.report().tried == found.loops + finder.report().refused + finder.report().not_again);
  // Submaps that drift are not quite alike.
  CHECK(found.farthest_m > 0.15);
  CHECK(found.worst_m < 0.08);
}

TEST_CASE("a place is found by how it looks where nothing is known of where it is", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(2, 0.3));
  FinderOptions options;
  options.most_distance_m = -1.0;
  LoopFinder finder(options);
  const Found found = find_all(finder, twice, drive);
  CHECK(finder.report().alike == finder.report().tried);
  CHECK(found.loops >= 1);
  CHECK(found.worst_m < 0.08);
}

TEST_CASE("neighbours in time are no candidates, nor is what lies out of reach", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(1, 0.0));
  FinderOptions options;
  options.most_distance_m = -1.0;
  options.least_likeness = 1.1;
  LoopFinder none(options);
  LoopFinder finder;
  CHECK(finder.find(drive.chain()).empty());
  for (int i = 0; i < 4 && drive.next_submap(); ++i) CHECK(finder.find(drive.chain()).empty());
  CHECK(finder.report().tried == 0);
  while (drive.next_submap()) CHECK(none.find(drive.chain()).empty());
  CHECK(none.report().tried == 0);
}
