// SPDX-License-Identifier: Apache-2.0
// The card's memory when it is short or much used: full pools, and a table that forgets as much as it learns.
#include "mapper/cuda/memory.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>
#include <span>

#include "mapper/map_hash.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

using Blocks = std::map<BlockKey, BlockValues>;

Blocks all_blocks(const VoxelMap& map) {
  Blocks blocks;
  for (const BlockKey key : map.sorted_keys()) map.read_block(key, blocks[key]);
  return blocks;
}

BlockValues block_in(const Blocks& blocks, BlockKey key) {
  if (const auto found = blocks.find(key); found != blocks.end()) return found->second;
  BlockValues unknown;
  unknown.fill(kUnknownRgbo);
  return unknown;
}

/// Every voxel has its level, and its colour or none.
bool lacks_only_colours(const BlockValues& got, const BlockValues& whole) {
  for (std::size_t i = 0; i < got.size(); ++i) {
    if (got[i] != whole[i] && got[i] != level_of(whole[i])) return false;
  }
  return true;
}

/// A CPU twin that has room. To make one takes longer than a frame.
std::unique_ptr<Mapper> roomy_mapper(MapperConfig config, const hal::CameraModel& camera) {
  config.capacity = {1U << 12, 1U << 12, 1U << 12};
  return std::make_unique<Mapper>(config, camera);
}

void make_equal(VoxelMap& map, const VoxelMap& to) {
  for (const BlockKey key : map.sorted_keys()) map.erase_block(key);
  BlockValues values;
  for (const BlockKey key : to.sorted_keys()) {
    to.read_stored_block(key, values);
    REQUIRE(map.write_block(key, values));
  }
}

/// What the host may do between frames: forgets some blocks, and fills the room with others of its own.
void trade_blocks(VoxelMap& map, std::uint64_t seed) {
  tests::Random random(seed);
  for (const BlockKey key : map.sorted_keys()) {
    if (random.below(3) == 0) map.erase_block(key);
  }
  BlockValues values;
  for (int i = 0; i < 40; ++i) {
    values.fill(random.below(16));
    if (i % 2 == 0) values[random.below(512)] = make_rgbo(9, 8, 7, 25) | kHasColourBit;
    (void)map.write_block(random.below(1000), values);
  }
}

}  // namespace

TEST_CASE("with full pools a block has all of a frame, its levels without colours, or nothing of it; and it is counted",
          "[slow]") {
  const hal::CameraModel camera = test::small_camera(60);
  const std::array<MapCapacity, 5> tiny{
      {{0, 0, 0}, {60, 1000, 1000}, {1000, 30, 1000}, {1000, 1000, 20}, {300, 60, 60}}};
  for (const IntegratorKind kind : {IntegratorKind::projective, IntegratorKind::bresenham, IntegratorKind::dda}) {
    for (const MapCapacity& capacity : tiny) {
      INFO(to_string(kind) << ", room for " << capacity.blocks << " blocks, " << capacity.planes << " planes, "
                           << capacity.colour_bricks << " bricks");
      MapperConfig config;
      config.integrator = kind;
      config.capacity = capacity;
      test::EmulatedMapper emulated(config, camera, 11);
      const auto roomy = roomy_mapper(config, camera);
      std::uint32_t refused = 0;
      for (const auto& [frame, pose] : test::random_frames(camera, 6, 11)) {
        if (emulated.frame_number > 2) trade_blocks(emulated.map, emulated.frame_number);
        const Blocks before = all_blocks(emulated.map);
        make_equal(roomy->map(), emulated.map);
        const FrameReport report = emulated.integrate(frame, pose);  // the card is not lost
        const FrameReport whole_report = roomy->integrate(frame, pose);
        CHECK(report.valid_pixels == whole_report.valid_pixels);
        REQUIRE(whole_report.refused_blocks == 0);
        const Blocks after = all_blocks(emulated.map);
        Blocks whole = all_blocks(roomy->map());
        for (const auto& [key, values] : before) whole.try_emplace(key, block_in({}, key));
        std::set<BlockKey> told;
        for (const std::uint32_t slot : emulated.twin.changed_slots()) told.insert(emulated.map.header(slot).key);
        CHECK(told.size() == emulated.twin.changed_slots().size());
        std::uint32_t kept_from = 0;
        std::uint32_t wrong = 0;
        std::uint32_t untold = 0;
        for (const auto& [key, expected] : whole) {
          const BlockValues got = block_in(after, key);
          const BlockValues old = block_in(before, key);
          untold += got != old && !told.contains(key) ? 1 : 0;
          if (got == expected) continue;
          ++kept_from;
          wrong += got != old && !lacks_only_colours(got, expected) ? 1 : 0;
        }
        CHECK(wrong == 0);
        CHECK(untold == 0);
        CHECK(kept_from <= report.refused_blocks);
        for (const auto& [key, values] : after) CHECK(whole.contains(key));
        refused += report.refused_blocks;
      }
      CHECK(refused > 0);
    }
  }
}

TEST_CASE("a map that was full and has room again becomes what it would be anywhere") {
  const hal::CameraModel camera = test::small_camera(60);
  const auto frames = test::random_frames(camera, 5, 12);
  MapperConfig config;
  config.capacity = {1U << 14, 1U << 13, 1U << 14};
  Mapper roomy(config, camera);
  for (int i = 0; i < 2; ++i) (void)roomy.integrate(frames[4].frame, frames[4].T_world_camera);
  config.capacity = {roomy.map().block_count(), 1U << 13, 1U << 14};  // room for one of the frames, not for all
  test::EmulatedMapper emulated(config, camera, 12);
  std::uint32_t refused = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    refused += emulated.integrate(frames[i].frame, frames[i].T_world_camera).refused_blocks;
  }
  REQUIRE(refused > 0);
  for (std::uint32_t slot = 0; slot < emulated.map.slot_end(); ++slot) {
    const BlockKey key = emulated.map.header(slot).key;
    if (key != VoxelMap::kNoKey) emulated.map.erase_block(key);
  }
  for (int i = 0; i < 2; ++i) {
    CHECK(emulated.integrate(frames[4].frame, frames[4].T_world_camera).refused_blocks == 0);
  }
  CHECK(map_hash(emulated.map) == map_hash(roomy.map()));
}

TEST_CASE("a card's table does not fill up with what it forgot, however long the map follows the robot") {
  const hal::CameraModel camera = test::small_camera(32);
  MapperConfig config;
  config.resolution_m = 0.2F;
  config.capacity = {256, 128, 128};
  test::EmulatedMapper emulated(config, camera, 13);
  const auto frames = test::random_frames(camera, 1, 13);
  tests::Random random(13);
  BlockValues values;
  values.fill(3);
  for (int round = 0; round < 60; ++round) {
    for (const BlockKey key : emulated.map.sorted_keys()) emulated.map.erase_block(key);
    for (int i = 0; i < 100; ++i) REQUIRE(emulated.map.write_block(random.below(1U << 30), values));
    CHECK(emulated.integrate(frames[0].frame, frames[0].T_world_camera).refused_blocks == 0);
  }
  const cuda::Memory& memory = emulated.card->memory();
  const std::span<const std::uint64_t> places{memory.table_keys, std::size_t{memory.table_mask} + 1};
  const auto forgotten = std::count(places.begin(), places.end(), cuda::kForgotten);
  const auto empty = std::count(places.begin(), places.end(), std::uint64_t{0});
  CHECK(static_cast<std::size_t>(forgotten) < places.size() / 10);
  CHECK(static_cast<std::size_t>(empty) > places.size() / 2);
}
