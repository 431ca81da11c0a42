// SPDX-License-Identifier: Apache-2.0
// Random evidence on a few blocks, over many frames, against the update rules applied voxel by voxel.
#include "mapper/cpu/block_updater.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "mapper/map_hash.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;
using tests::Random;

namespace {

constexpr std::uint32_t kChunks = 5;
constexpr std::uint32_t kBlocksPerChunk = 8;

/// What one frame says about one block.
struct Evidence {
  std::uint32_t block_id = 0;
  std::uint32_t chunk = 0;
  bool all_free = false;
  bool some_free = false;
  FreeFlags free{};
  std::unique_ptr<HitRecord> hits;
};

// Chosen by the place alone, as the projective test's answer is by the pixels.
bool is_strong(int place) { return place % 3 == 0; }

struct Scene {
  hal::CameraModel camera = test::small_camera(40);
  SensorGeometry sensor{camera, 0.1F, 0.8F, 3.5F};
  FrameGeometry frame = frame_geometry(sensor, {}).value();
  Random random;

  explicit Scene(std::uint64_t seed) : random(seed) {}

  /// Of the first 40 blocks of the box, those with anything to say; a block keeps its chunk.
  std::vector<Evidence> next() {
    std::vector<Evidence> all;
    for (std::uint32_t id = 0; id < kChunks * kBlocksPerChunk; ++id) {
      if (random.below(3) == 0) continue;
      Evidence e;
      e.block_id = id;
      e.chunk = id / kBlocksPerChunk;
      e.all_free = random.below(3) == 0;
      e.some_free = !e.all_free && random.below(2) == 0;
      for (std::uint8_t& flag : e.free) flag = std::array<std::uint8_t, 3>{0, kWeakFree, kStrongFree}[random.below(3)];
      if (random.below(3) == 0) {
        e.hits = std::make_unique<HitRecord>();
        e.hits->block_id = id;
        e.hits->consumed = 0;
        e.hits->flags.fill(0);
        const std::uint32_t kind = random.below(3);  // all were trusted, some were too near, all were
        e.hits->held_only = kind == 2 ? 1 : 0;
        for (std::size_t i = 0; i < kBlockVoxels; ++i) {
          if (random.below(id % 2 == 0 ? 100 : 4) != 0) continue;
          const std::uint8_t hit = random.below(3) == 0 ? kHitFlag : kHitFlag | kColourFlag;
          e.hits->flags[i] = hit;
          if (kind == 2 || (kind == 1 && random.below(3) == 0)) e.hits->flags[i] = kHeldFlag;
          if (kind == 1 && random.below(4) == 0) e.hits->flags[i] = static_cast<std::uint8_t>(hit | kHeldFlag);
          e.hits->rgb[i] = random.below(1U << 24);
        }
      }
      if (e.all_free || e.some_free || e.hits) all.push_back(std::move(e));
    }
    return all;
  }

  void apply(std::vector<Evidence>& all, BlockUpdater& updater, bool with_colour, ThreadPool& pool,
             std::uint32_t number) const {
    updater.begin(frame, with_colour, best_kernels(), number, kChunks, kBlocksPerChunk, pool.threads() == 1);
    pool.parallel_for(kChunks, [&](std::uint32_t chunk) {
      for (Evidence& e : all) {
        if (e.chunk != chunk) continue;
        const BlockKey key = frame.block_key(e.block_id);
        if (e.all_free) {
          updater.offer_all_free(chunk, key, e.hits.get(), is_strong);
        } else if (e.some_free) {
          FreeFlags flags = e.free;
          updater.offer_some_free(chunk, key, flags, e.hits.get(), is_strong);
        } else {
          updater.offer_hits(chunk, key, *e.hits);
        }
      }
    });
  }

  void apply_plainly(const std::vector<Evidence>& all, bool with_colour, UpdateSteps steps,
                     std::map<MCode, test::PlainVoxel>& voxels) const {
    for (const Evidence& e : all) {
      for (MCode place = 0; place < kBlockVoxels; ++place) {
        const std::uint8_t hit = e.hits ? e.hits->flags[place] : std::uint8_t{0};
        const std::uint8_t flag = e.all_free ? kWeakFree : e.some_free ? e.free[place] : std::uint8_t{0};
        test::Seen seen = flag == kStrongFree ? test::Seen::strong
                          : flag == kWeakFree ? test::Seen::weak
                                              : test::Seen::no;
        if (seen == test::Seen::weak && is_strong(static_cast<int>(place))) seen = test::Seen::strong;
        if ((hit & kHeldFlag) != 0) seen = test::Seen::no;
        const std::uint32_t c = e.hits ? e.hits->rgb[place] : 0U;
        const std::array<std::uint8_t, 3> rgb{static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(c >> 8),
                                              static_cast<std::uint8_t>(c >> 16)};
        const bool coloured = (hit & kColourFlag) != 0 && with_colour;
        test::plain_update(voxels[(frame.block_key(e.block_id) << kBlockShift) | place], (hit & kHitFlag) != 0, seen,
                           coloured ? rgb.data() : nullptr, steps);
      }
    }
  }
};

int differences(const VoxelMap& map, const std::map<MCode, test::PlainVoxel>& voxels) {
  int count = 0;
  for (const auto& [code, v] : voxels)
    count += map.at(code) == make_rgbo(v.rgb[0], v.rgb[1], v.rgb[2], v.level) ? 0 : 1;
  return count;
}

}  // namespace

TEST_CASE("evidence moves voxels as the rules say, for any number of threads", "[threads]") {
  for (const int threads : {1, 3}) {
    for (const UpdateSteps steps : {UpdateSteps{}, UpdateSteps{16, 16}, UpdateSteps{1, 5}}) {
      Scene scene(7);
      VoxelMap map(Grid{0.1F}, {256, 256, 2048});
      BlockUpdater updater(map, scene.sensor, steps);
      ThreadPool pool(threads);
      std::map<MCode, test::PlainVoxel> voxels;
      for (std::uint32_t number = 1; number <= 24; ++number) {
        auto all = scene.next();
        const bool with_colour = number % 7 != 0;
        const auto before = voxels;
        scene.apply(all, updater, with_colour, pool, number);
        REQUIRE(updater.finish(pool) == 0);
        scene.apply_plainly(all, with_colour, steps, voxels);
        REQUIRE(differences(map, voxels) == 0);
        for (const Evidence& e : all) {
          if (e.hits) REQUIRE(e.hits->consumed == 1);
        }

        std::set<BlockKey> changed;
        for (const auto& [code, v] : voxels) {
          const auto old = before.find(code);
          if ((old == before.end() ? test::PlainVoxel{} : old->second) != v) changed.insert(code >> kBlockShift);
        }
        std::set<BlockKey> reported;
        for (const std::uint32_t slot : updater.changed_slots()) {
          REQUIRE(reported.insert(map.header(slot).key).second);
          REQUIRE(map.header(slot).changed_frame == number);
        }
        REQUIRE(reported == changed);
      }
    }
  }
}

TEST_CASE("memory that is no longer needed is given back") {
  Scene scene(8);
  VoxelMap map(Grid{0.1F}, {256, 256, 2048});
  BlockUpdater updater(map, scene.sensor, {});
  ThreadPool pool(1);
  const std::size_t empty_bytes = map.memory().used_bytes;
  for (std::uint32_t number = 1; number <= 20; ++number) {
    auto all = scene.next();
    scene.apply(all, updater, true, pool, number);
    REQUIRE(updater.finish(pool) == 0);
  }
  CHECK(map.counts().uniform_blocks < map.counts().blocks);
  const auto blocks = static_cast<std::size_t>(map.block_count());
  for (std::uint32_t number = 21; number <= 60; ++number) {
    std::vector<Evidence> all;
    for (std::uint32_t id = 0; id < kChunks * kBlocksPerChunk; ++id) {
      Evidence e;
      e.block_id = id;
      e.chunk = id / kBlocksPerChunk;
      e.some_free = true;
      e.free.fill(kStrongFree);
      all.push_back(std::move(e));
    }
    scene.apply(all, updater, true, pool, number);
    REQUIRE(updater.finish(pool) == 0);
  }
  CHECK(map.counts().uniform_blocks == map.counts().blocks);
  CHECK(map.counts().occupied == 0);
  CHECK(map.memory().used_bytes == empty_bytes + map.block_count() * sizeof(BlockHeader));
  CHECK(map.block_count() >= blocks);
  CHECK(updater.changed_slots().empty());
  CHECK(updater.is_settled(updater.slot_of(scene.frame.block_key(0))));
}

TEST_CASE("what a full pool refuses and what changed, in which order, does not depend on the number of threads",
          "[threads]") {
  for (const MapCapacity& capacity :
       {MapCapacity{10, 99, 999}, MapCapacity{99, 7, 999}, MapCapacity{99, 99, 9}, MapCapacity{0, 0, 0}}) {
    std::set<std::string> hashes;
    std::set<std::uint32_t> refusals;
    std::set<std::vector<std::uint32_t>> changes;
    for (const int threads : {1, 2, 4}) {
      Scene scene(9);
      VoxelMap map(Grid{0.1F}, capacity);
      BlockUpdater updater(map, scene.sensor, {});
      ThreadPool pool(threads);
      std::uint32_t refused = 0;
      std::vector<std::uint32_t> changed;
      for (std::uint32_t number = 1; number <= 20; ++number) {
        auto all = scene.next();
        scene.apply(all, updater, true, pool, number);
        refused += updater.finish(pool);
        const auto slots = updater.changed_slots();
        changed.insert(changed.end(), slots.begin(), slots.end());
      }
      changes.insert(std::move(changed));
      hashes.insert(map_hash(map));
      refusals.insert(refused);
      CHECK(map.block_count() <= capacity.blocks);
    }
    CHECK(hashes.size() == 1);
    CHECK(refusals.size() == 1);
    CHECK(changes.size() == 1);
    CHECK(*refusals.begin() > 0);
  }
}

TEST_CASE("a remembered slot is forgotten when the block goes") {
  Scene scene(10);
  VoxelMap map(Grid{0.1F}, {16, 16, 16});
  BlockUpdater updater(map, scene.sensor, {});
  const BlockKey key = scene.frame.block_key(3);
  CHECK(updater.slot_of(key) == kNoSlot);
  const std::uint32_t slot = map.find_or_insert(key);
  CHECK(updater.slot_of(key) == slot);
  CHECK(updater.remembered_slot(key) == slot);
  map.erase_block(key);
  CHECK(updater.slot_of(key) == kNoSlot);
  const std::uint32_t other = map.find_or_insert(scene.frame.block_key(4));
  CHECK(other == slot);  // the slot lives on as another block
  CHECK(updater.slot_of(key) == kNoSlot);
  CHECK_FALSE(updater.is_settled(kNoSlot));
  map.clear();
  CHECK(updater.slot_of(scene.frame.block_key(4)) == kNoSlot);
}
