// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_search.hpp"

#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "tests/support/looped_drive.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

TEST_CASE("a search beside the mapping finds what one in its place would, and has the moved map ready", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(1, 0.3));
  LoopCloser in_place;
  LoopSearch beside;
  int moves = 0;
  while (drive.next_submap()) {
    const bool has_moved = in_place.add_submap(drive.chain());
    CHECK_FALSE(beside.is_busy());
    beside.ask(drive.chain());
    CHECK(beside.is_busy());
    beside.wait();
    REQUIRE(beside.has_answer());
    MovedSubmaps moved = beside.take();
    CHECK_FALSE(beside.is_busy());
    REQUIRE((moved.placed != nullptr) == has_moved);
    if (!has_moved) continue;
    ++moves;
    REQUIRE(beside.closer().T_world_stored().size() == drive.chain().submaps().size());
    for (std::size_t i = 0; i < in_place.T_world_stored().size(); ++i) {
      CHECK(beside.closer().T_world_stored()[i].translation_m == in_place.T_world_stored()[i].translation_m);
    }
    PlacedSubmaps placed(drive.chain().view().grid());
    for (std::size_t i = 0; i < drive.chain().submaps().size(); ++i) {
      placed.add(*drive.chain().submaps()[i].voxels, in_place.T_world_stored()[i]);
    }
    CHECK(map_hash(*moved.whole) == map_hash(*placed.whole()));
  }
  CHECK(moves > 0);
}

TEST_CASE("a search that nobody waits for ends with its owner", "[threads]") {
  VoxelMap view(Grid{0.05F}, {64, 64, 64});
  SubmapChain chain(view);
  chain.add_frame(1, {}, {});
  REQUIRE(chain.finish_submap());
  for (int i = 0; i < 20; ++i) {
    LoopSearch search;
    search.ask(chain);
    // Frames go into the chain meanwhile.
    chain.add_frame(2 + i, {}, {});
    if (i % 2 == 0) continue;
    search.wait();
    CHECK(search.take().placed == nullptr);
  }
}
