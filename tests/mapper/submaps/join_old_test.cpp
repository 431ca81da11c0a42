// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/join_old.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "mapper/align/pose_step.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/looped_drive.hpp"
#include "tests/support/memory_page_file.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

std::vector<Submap> row(std::size_t count) {
  std::vector<Submap> submaps(count);
  for (std::size_t i = 0; i < count; ++i) {
    submaps[i].T_stored_anchor = hal::from_xyz_rpy(static_cast<double>(i), 0, 0, 0, 0, 0);
    submaps[i].stations.resize(1);
  }
  return submaps;
}

std::string hash_of(const SubmapChain& chain) {
  PlacedSubmaps placed(chain.view().grid());
  for (const Submap& submap : chain.submaps()) placed.add(*submap.contents, submap.T_world_stored);
  return map_hash(*placed.whole());
}

}  // namespace

TEST_CASE("old submaps are joined beyond their number, small ones that agree first, the newest never") {
  const JoinRule rule{.most_submaps = 6, .newest = 2};
  CHECK_FALSE(choose_join(row(6), rule));
  std::vector<Submap> submaps = row(7);
  CHECK(choose_join(submaps, rule) == 0);
  submaps[0].stations.resize(3);
  CHECK(choose_join(submaps, rule) == 1);
  submaps[1].T_world_stored = submaps[2].T_world_stored = hal::from_xyz_rpy(0, 0.1, 0, 0, 0, 0);
  submaps[0].T_world_stored = submaps[1].T_world_stored;
  CHECK(choose_join(submaps, rule) == 1);  // moved, but not against each other
  submaps[1].T_world_stored = {};
  CHECK(choose_join(submaps, rule) == 3);  // a correction has bent the chain at 1 and 2
  for (std::size_t i = 0; i < 4; ++i) submaps[i].stations.resize(50);
  CHECK(choose_join(submaps, rule) == 3);  // 4 and 5 are too young, however small
  CHECK_FALSE(choose_join(row(7), {.most_submaps = 2, .newest = 6}));
}

TEST_CASE("joined submaps say what they said one by one, and are bounded in number", "[slow]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  test::UnalignedDrive drive(twice, hal::robot_drift(1, 0.0));
  LoopCloser closer;
  std::uint64_t most_bytes = 0;
  while (drive.next_submap()) {
    SubmapChain& chain = drive.chain();
    const std::string before = hash_of(chain);
    join_old(chain, closer, {.most_submaps = 3, .newest = 1});
    CHECK(chain.submaps().size() <= 3);
    CHECK(hash_of(chain) == before);
    (void)closer.add_submap(chain);
    CHECK(closer.graph().nodes().size() == chain.submaps().size());
    most_bytes = std::max(most_bytes, chain.memory_bytes());
  }
  CHECK(closer.report().joined > 0);
  CHECK(drive.chain().submaps().front().stations.size() > 1);
  CHECK(most_bytes > 0);
}

TEST_CASE("submaps that lie on the shelf are joined as those in memory, and their records go") {
  const auto joined = [](SubmapShelf* shelf) {
    VoxelMap view(Grid{0.05F}, {256, 256, 256});
    SubmapChain chain(view, {}, shelf);
    LoopCloser closer;
    BlockValues values;
    for (int i = 0; i < 6; ++i) {
      values.fill(static_cast<Rgbo>(20 + i));
      values[static_cast<std::size_t>(i)] = 4;
      const BlockKey key = block_of({32768 + 4 * i, 32768, 32768});
      REQUIRE(view.write_block(key, values));
      chain.add_frame(i, hal::from_xyz_rpy(0.2 * i, 0, 0, 0, 0, 0), std::array{view.find(key)});
      REQUIRE(chain.finish_submap());
      closer.add_following(chain);
    }
    chain.put_away_all_but(0);
    if (shelf != nullptr) REQUIRE(shelf->size() == 6);
    join_old(chain, closer, {.most_submaps = 3, .newest = 1});
    REQUIRE(chain.submaps().size() == 3);
    chain.put_away_all_but(0);
    if (shelf != nullptr) CHECK(shelf->size() == 3);
    return hash_of(chain);
  };
  SubmapShelf shelf(std::make_unique<tests::MemoryPageFile>());
  CHECK(joined(&shelf) == joined(nullptr));
  CHECK(shelf.size() == 0);
  CHECK(shelf.counts().failed_loads == 0);
}
