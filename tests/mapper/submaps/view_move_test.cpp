// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/view_move.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <set>

#include "mapper/map_hash.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

/// Three submaps of a random world, the second and third of which are moved.
struct Moved {
  VoxelMap view{Grid{0.05F}, {1U << 12, 1U << 12, 64}};
  SubmapChain chain{view};
  std::array<hal::Pose, 3> poses{hal::Pose{}, hal::from_xyz_rpy(0.3, -0.2, 0, 0, 0, 0.05),
                                 hal::from_xyz_rpy(1.3, 0.2, 0, 0, 0, -0.1)};

  Moved() {
    std::uint32_t random = 7;
    for (int submap = 0; submap < 3; ++submap) {
      std::vector<std::uint32_t> slots;
      for (int i = 0; i < 60; ++i) {
        BlockValues values;
        random = random * 1664525U + 1013904223U;
        const auto at = [&](int shift) { return 32768 + static_cast<std::int32_t>((random >> shift) % 160); };
        const BlockKey key = block_of({at(8) + 40 * submap, at(16), 32768 + static_cast<std::int32_t>(random >> 28)});
        values.fill(kUnknownRgbo);
        for (std::size_t v = 0; v < values.size(); v += 1 + random % 7) values[v] = 1 + (random + v) % 32;
        std::replace(values.begin(), values.end(), Rgbo{16}, Rgbo{17});
        REQUIRE(view.write_block(key, values));
        slots.push_back(view.find(key));
      }
      std::sort(slots.begin(), slots.end());
      slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
      chain.add_frame(submap + 1, {}, slots);
      REQUIRE(chain.finish_submap());
    }
  }
  /// All but the newest, as a search answers.
  struct Answer {
    std::unique_ptr<PlacedSubmaps> placed;
    std::unique_ptr<VoxelMap> whole;
  };
  Answer answer() {
    Answer moved;
    moved.placed = std::make_unique<PlacedSubmaps>(view.grid());
    for (std::size_t i = 0; i < 2; ++i) moved.placed->add(*chain.submaps()[i].contents, poses[i]);
    moved.whole = moved.placed->whole();
    return moved;
  }
};

}  // namespace

TEST_CASE("a view that is moved part by part is the one that is made anew") {
  Moved from_scratch;
  from_scratch.chain.place(from_scratch.poses);
  from_scratch.chain.rebuild();

  Moved by_parts;
  const std::string before = map_hash(by_parts.view);
  Moved::Answer answer = by_parts.answer();
  by_parts.chain.place(by_parts.poses, std::move(answer.placed));
  ViewMove move(by_parts.view, 20);
  CHECK(move.is_done());
  move.begin(by_parts.chain, std::move(answer.whole), 1);
  // Somebody who follows the view by its slots alone.
  std::vector<BlockKey> followed(by_parts.view.capacity().blocks, VoxelMap::kNoKey);
  std::set<BlockKey> known;
  for (std::uint32_t slot = 0; slot < by_parts.view.slot_end(); ++slot) {
    followed[slot] = by_parts.view.header(slot).key;
    known.insert(followed[slot]);
  }
  int parts = 0;
  while (!move.is_done()) {
    const auto slots = move.go_on();
    CHECK(slots.size() <= 20);
    CHECK(std::set<std::uint32_t>(slots.begin(), slots.end()).size() == slots.size());
    for (const std::uint32_t slot : slots) {
      const BlockKey key = by_parts.view.header(slot).key;
      if (key == VoxelMap::kNoKey) known.erase(followed[slot]);
      followed[slot] = key;
      if (key != VoxelMap::kNoKey) known.insert(key);
    }
    REQUIRE(++parts < 100);
  }
  CHECK(parts > 5);
  CHECK(map_hash(by_parts.view) == map_hash(from_scratch.view));
  CHECK(map_hash(by_parts.view) != before);
  CHECK(move.refused_blocks() == 0);
  for (const BlockKey key : by_parts.view.sorted_keys()) CHECK(known.count(key) == 1);
  known.erase(VoxelMap::kNoKey);
  for (const BlockKey key : known) CHECK(by_parts.view.find(key) != kNoSlot);
  CHECK(move.go_on().empty());
}

TEST_CASE("what stands where it stood is not touched") {
  Moved m;
  m.poses = {};
  Moved::Answer answer = m.answer();
  m.chain.place(m.poses, std::move(answer.placed));
  ViewMove move(m.view, 50);
  move.begin(m.chain, std::move(answer.whole), 1);
  while (!move.is_done()) CHECK(move.go_on().empty());
}
