// SPDX-License-Identifier: Apache-2.0
// The map against a std::map that does the same slowly, with pools so small that they are full half of the time.
#include "mapper/voxel_map.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <map>
#include <thread>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d::mapper;
using g3d::tests::Random;

namespace {

/// What a block of the map should be, and what memory it should hold.
struct ModelBlock {
  BlockValues stored;
  bool dense = false;
  std::uint8_t bricks = 0;
};
using Model = std::map<BlockKey, ModelBlock>;

Rgbo stored_form(Rgbo value) {
  const Rgbo level = std::min<Rgbo>(value & kLevelMask, kMaxLevel);
  if (level <= kUnknownLevel) return level;
  const bool coloured = (value & kHasColourBit) != 0 || (value >> 8) != 0;
  return coloured ? ((value >> 8) << 8) | kHasColourBit | level : level;
}
Rgbo published_form(Rgbo stored) { return stored & ~Rgbo{kHasColourBit}; }

ModelBlock model_block(const BlockValues& values) {
  ModelBlock block;
  bool equal = true;
  for (std::size_t i = 0; i < values.size(); ++i) {
    block.stored[i] = stored_form(values[i]);
    equal &= block.stored[i] == block.stored[0];
    if ((block.stored[i] & kHasColourBit) != 0)
      block.bricks = static_cast<std::uint8_t>(block.bricks | (1U << (i / 64)));
  }
  block.dense = !equal || block.bricks != 0;
  return block;
}

struct ModelUse {
  std::uint32_t planes = 0;
  std::uint32_t bricks = 0;
};
ModelUse use_of(const Model& model) {
  ModelUse use;
  for (const auto& [key, block] : model) {
    use.planes += block.dense ? 1U : 0U;
    use.bricks += static_cast<std::uint32_t>(__builtin_popcount(block.bricks));
  }
  return use;
}

bool has_room(const Model& model, const MapCapacity& capacity, BlockKey key, const ModelBlock& next) {
  const ModelUse use = use_of(model);
  const auto old = model.find(key);
  const bool is_new = old == model.end();
  const bool plane = next.dense && (is_new || !old->second.dense);
  const unsigned had = is_new ? 0U : old->second.bricks;
  const auto bricks = static_cast<std::uint32_t>(__builtin_popcount(next.bricks & ~had));
  return !(is_new && model.size() == capacity.blocks) && !(plane && use.planes == capacity.planes) &&
         bricks <= capacity.colour_bricks - use.bricks;
}

bool same(const VoxelMap& map, const Model& model) {
  if (map.block_count() != model.size()) return false;
  std::vector<BlockKey> known;
  for (const auto& [key, block] : model) {
    BlockValues stored;
    BlockValues published;
    if (!map.read_stored_block(key, stored) || !map.read_block(key, published) || stored != block.stored) return false;
    bool any = false;
    for (std::size_t i = 0; i < stored.size(); ++i) {
      if (published[i] != published_form(stored[i])) return false;
      any |= stored[i] != kUnknownRgbo;
    }
    if (any) known.push_back(key);
  }
  return map.sorted_keys() == known;
}

BlockValues random_values(Random& random) {
  BlockValues values;
  const std::uint32_t kind = random.below(5);
  const std::uint32_t base = random.below(33);
  for (std::size_t i = 0; i < values.size(); ++i) {
    Rgbo value = base;
    if (kind == 1) value = random.below(33);
    if (kind == 2 && i / 64 == base % 8) value = (random.below(1U << 24) << 8) | random.below(33);
    if (kind == 3) value = (random.below(1U << 24) << 8) | random.below(64) | (random.below(2) << 6);
    if (kind == 4) value = static_cast<Rgbo>(random.next());  // nonsense above level 32, spare bits and all
    values[i] = value;
  }
  return values;
}

}  // namespace

TEST_CASE("random writing, erasing and reading agree with a plain map, also when pools are full") {
  Random random(11);
  const MapCapacity capacity{40, 16, 60};
  VoxelMap map(Grid{0.05F}, capacity);
  Model model;
  std::vector<BlockKey> keys;
  for (int i = 0; i < 70; ++i) keys.push_back(random.next() >> 25);
  int refused = 0;
  for (int step = 0; step < 6000; ++step) {
    const BlockKey key = keys[random.below(static_cast<std::uint32_t>(keys.size()))];
    const std::uint32_t action = random.below(10);
    if (action < 5) {
      const BlockValues values = random_values(random);
      const ModelBlock next = model_block(values);
      const bool room = has_room(model, capacity, key, next);
      REQUIRE(map.write_block(key, values) == room);
      if (room) model[key] = next;
      refused += room ? 0 : 1;
    } else if (action < 8) {
      REQUIRE(map.erase_block(key) == (model.erase(key) == 1));
    } else if (action == 8) {
      const std::uint32_t slot = map.find(key);
      REQUIRE((slot != kNoSlot) == model.contains(key));
      if (slot == kNoSlot) continue;
      const bool room = model[key].dense || use_of(model).planes < capacity.planes;
      REQUIRE(map.make_dense(map.header(slot)) == room);
      model[key].dense |= room;
    } else if (const std::uint32_t slot = map.find(key); slot != kNoSlot) {
      const ModelBlock uniform = model_block(model[key].stored);
      REQUIRE(map.make_uniform_if_equal(map.header(slot)) == !uniform.dense);
      if (!uniform.dense) model[key] = uniform;
    }
    const MCode code = (key << kBlockShift) | random.below(kBlockVoxels);
    const Rgbo expected = model.contains(key) ? published_form(model[key].stored[code & kPlaceMask]) : kUnknownRgbo;
    REQUIRE(map.at(code) == expected);
    REQUIRE(map.at(decode(code)) == expected);
    if (step % 50 == 0) REQUIRE(same(map, model));
  }
  CHECK(same(map, model));
  CHECK(refused > 200);
  CHECK(refused < 3000);
}

TEST_CASE("a full pool refuses and leaves the map as it was") {
  BlockValues flat;
  flat.fill(3);
  BlockValues rough = flat;
  rough[5] = 20;
  BlockValues colourful = flat;
  for (std::size_t i = 0; i < flat.size(); i += 64) colourful[i] = make_rgbo(1, 2, 3, 32);
  SECTION("of blocks") {
    VoxelMap map(Grid{}, {2, 8, 64});
    REQUIRE(map.write_block(1, flat));
    REQUIRE(map.write_block(2, rough));
    CHECK_FALSE(map.write_block(3, flat));
    CHECK(map.find_or_insert(3) == kNoSlot);
    CHECK(map.sorted_keys() == std::vector<BlockKey>{1, 2});
    CHECK(map.erase_block(1));
    CHECK(map.write_block(3, flat));
  }
  SECTION("of planes") {
    VoxelMap map(Grid{}, {8, 1, 64});
    REQUIRE(map.write_block(1, rough));
    CHECK_FALSE(map.write_block(2, rough));
    CHECK(map.find(2) == kNoSlot);
    REQUIRE(map.write_block(3, flat));
    CHECK_FALSE(map.write_block(3, rough));
    CHECK(map.at(BlockKey{3} << kBlockShift | 5) == 3);
    CHECK(map.write_block(1, flat));  // gives its plane back
    CHECK(map.write_block(3, rough));
  }
  SECTION("of colour bricks") {
    VoxelMap map(Grid{}, {8, 8, 9});
    REQUIRE(map.write_block(1, colourful));
    CHECK_FALSE(map.write_block(2, colourful));
    CHECK(map.find(2) == kNoSlot);
    REQUIRE(map.write_block(2, rough));
    CHECK_FALSE(map.write_block(2, colourful));
    BlockValues kept;
    CHECK(map.read_block(2, kept));
    CHECK(kept == rough);
    CHECK(map.write_block(1, colourful));  // what it has it may keep
  }
}

TEST_CASE("a voxel that is not occupied has no colour, and black is a colour") {
  VoxelMap map(Grid{}, {8, 8, 8});
  BlockValues values;
  values.fill(kUnknownRgbo);
  values[0] = make_rgbo(9, 9, 9, 15);
  values[1] = make_rgbo(9, 9, 9, 16);
  values[2] = make_rgbo(0, 0, 0, 20) | kHasColourBit;
  values[3] = make_rgbo(0, 0, 0, 20);
  REQUIRE(map.write_block(7, values));
  BlockValues stored;
  REQUIRE(map.read_stored_block(7, stored));
  CHECK(stored[0] == 15);
  CHECK(stored[1] == 16);
  CHECK(stored[2] == (20U | kHasColourBit));
  CHECK(stored[3] == 20);
  REQUIRE(map.read_block(7, values));
  CHECK(values[2] == 20);
  CHECK(map.counts().coloured == 1);
}

TEST_CASE("what is nowhere is unknown") {
  const VoxelMap map(Grid{}, {8, 8, 8});
  BlockValues values;
  values.fill(1);
  CHECK_FALSE(map.read_block(5, values));
  CHECK(values[0] == kUnknownRgbo);
  CHECK(values[511] == kUnknownRgbo);
  CHECK(map.at(VoxelIndex{-1, 0, 0}) == kUnknownRgbo);
  CHECK(map.at(VoxelIndex{0, 65536, 0}) == kUnknownRgbo);
  CHECK(map.at(VoxelIndex{65535, 65535, 65535}) == kUnknownRgbo);
  CHECK(map.find(5) == kNoSlot);
}

TEST_CASE("counts and memory follow what the map holds") {
  VoxelMap map(Grid{}, {64, 64, 64});
  const std::size_t empty_bytes = map.memory().used_bytes;
  BlockValues values;
  values.fill(0);
  REQUIRE(map.write_block(1, values));
  CHECK(map.memory().used_bytes == empty_bytes + sizeof(BlockHeader));
  values.fill(32);
  REQUIRE(map.write_block(2, values));
  values.fill(kUnknownRgbo);
  values[3] = 10;
  values[70] = make_rgbo(1, 1, 1, 30);
  REQUIRE(map.write_block(3, values));
  CHECK(map.memory().used_bytes == empty_bytes + 3 * sizeof(BlockHeader) + sizeof(LevelPlane) + sizeof(ColourBrick));
  const MapCounts counts = map.counts();
  CHECK(counts.blocks == 3);
  CHECK(counts.uniform_blocks == 2);
  CHECK(counts.free == 513);
  CHECK(counts.occupied == 513);
  CHECK(counts.coloured == 1);
  CHECK(counts.known() == 1026);
  CHECK(map.memory().reserved_bytes >= 64 * (sizeof(BlockHeader) + sizeof(LevelPlane) + sizeof(ColourBrick)));
  map.clear();
  CHECK(map.memory().used_bytes == empty_bytes);
  CHECK(map.block_count() == 0);
  CHECK(map.find(1) == kNoSlot);
  CHECK(map.counts().known() == 0);
  REQUIRE(map.write_block(3, values));
  CHECK(map.at((MCode{3} << kBlockShift) | 3) == 10);
}

TEST_CASE("a budget in bytes becomes pools that fit into it") {
  for (const std::size_t budget_bytes : {std::size_t{1} << 22, std::size_t{1} << 26, std::size_t{1} << 30}) {
    const MapCapacity c = capacity_for_bytes(budget_bytes);
    const std::size_t bytes =
        c.blocks * sizeof(BlockHeader) + c.planes * sizeof(LevelPlane) + c.colour_bricks * sizeof(ColourBrick);
    CHECK(bytes <= budget_bytes);
    CHECK(bytes >= budget_bytes * 7 / 10);
  }
  CHECK(capacity_for_bytes(0).blocks >= 64);
}

TEST_CASE("a copy taken while the writer works is one state of the block, never a mixture", "[threads]") {
  // Blocks of one flavour n: every level 17 + n % 16, and while n is odd the colour (n, n, n) everywhere.
  VoxelMap map(Grid{}, {4, 4, 32});
  const auto write = [&](BlockKey key, std::uint32_t n) {
    BlockValues values;
    const auto shade = static_cast<std::uint8_t>(n % 16 + 1);
    const auto level = static_cast<std::uint8_t>(17 + n % 16);
    values.fill(n % 2 == 1 ? make_rgbo(shade, shade, shade, level) | kHasColourBit : Rgbo{level});
    return map.write_block(key, values);
  };
  REQUIRE(write(1, 0));
  REQUIRE(write(2, 1));
  const std::uint32_t slot = map.find(1);
  std::atomic<bool> stop{false};
  std::atomic<std::uint32_t> copies{0};
  std::atomic<std::uint32_t> torn{0};
  std::thread reader([&] {
    BlockValues values;
    BlockKey key = 0;
    while (!stop.load()) {
      if (map.copy_block(slot, key, values)) {
        // A block that has just been born is wholly unknown.
        const std::uint32_t n = level_of(values[0]) - 17U;
        const auto shade = static_cast<std::uint8_t>(n + 1);
        const Rgbo coloured = make_rgbo(shade, shade, shade, static_cast<std::uint8_t>(17 + n)) | kHasColourBit;
        const Rgbo expected = values[0] == kUnknownRgbo ? kUnknownRgbo : n % 2 == 1 ? coloured : 17 + n;
        for (const Rgbo value : values) torn.fetch_add(value == expected ? 0 : 1);
        if (key != 1) torn.fetch_add(1);
      }
      copies.fetch_add(1);
    }
  });
  for (std::uint32_t n = 0; n < 3000 || copies.load() < 100; ++n) {
    if (n % 7 == 3) REQUIRE(map.erase_block(1));  // its memory goes to block 2, and comes back
    REQUIRE(write(2, n * 5));
    REQUIRE(write(1, n));
    if (n % 64 == 0) std::this_thread::yield();
  }
  stop.store(true);
  reader.join();
  CHECK(torn.load() == 0);
  BlockValues values;
  BlockKey key = 0;
  CHECK_FALSE(map.copy_block(3, key, values));  // never handed out
  CHECK_FALSE(map.copy_block(99, key, values));
}
