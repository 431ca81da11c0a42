// SPDX-License-Identifier: Apache-2.0
// One grid of occupancy and colour: a hash table from block key (M >> 9) to blocks of 8x8x8 voxels.
//
//   hash slot -> BlockHeader ─┬─ uniform: one level for all 512 voxels, no further memory
//                             ├─ level plane: 512 bytes, one per voxel (level 0..32, bit 6 = has a colour)
//                             └─ colour bricks: up to eight of 4x4x4 voxels x RGB, only where there is surface
//
// All memory is reserved at construction; a full pool refuses new blocks and says so, it never crashes or forgets.
// Threads: one writer. Concurrent readers use copy_block(), which is consistent per block by its sequence lock.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapper/grid.hpp"
#include "mapper/morton.hpp"
#include "mapper/pool.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper {

/// How many of each a map may hold. `capacity_for_bytes` splits one budget sensibly.
struct MapCapacity {
  std::uint32_t blocks = 1U << 18;
  std::uint32_t planes = 1U << 16;
  std::uint32_t colour_bricks = 1U << 17;
};
[[nodiscard]] MapCapacity capacity_for_bytes(std::size_t budget_bytes);
[[nodiscard]] constexpr bool fits(const MapCapacity& wanted, const MapCapacity& available) {
  return wanted.blocks <= available.blocks && wanted.planes <= available.planes &&
         wanted.colour_bricks <= available.colour_bricks;
}

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
inline constexpr int kBricksPerBlock = 8;
inline constexpr int kBrickVoxels = 64;

using LevelPlane = std::array<std::uint8_t, kBlockVoxels>;
using ColourBrick = std::array<std::uint8_t, 3 * kBrickVoxels>;

/// 512 RGBO-codes in order of `M & 511`.
using BlockValues = std::array<Rgbo, kBlockVoxels>;

struct BlockHeader {
  BlockKey key = 0;
  std::atomic<std::uint32_t> sequence{0};               ///< odd while the writer is inside
  std::uint32_t plane = kNoSlot;                        ///< kNoSlot: uniform
  std::array<std::uint32_t, kBricksPerBlock> bricks{};  ///< kNoSlot where no voxel of the brick has a colour
  std::uint32_t changed_frame = 0;                      ///< number of the last frame that changed it (low 32 bits)
  std::uint8_t uniform_level = kUnknownLevel;           ///< valid when plane == kNoSlot
};

struct MapCounts {
  std::uint64_t occupied = 0;
  std::uint64_t free = 0;
  std::uint64_t coloured = 0;
  std::uint64_t blocks = 0;
  std::uint64_t uniform_blocks = 0;
  [[nodiscard]] std::uint64_t known() const { return occupied + free; }
  bool operator==(const MapCounts&) const = default;
};

struct MapMemory {
  std::size_t used_bytes = 0;      ///< headers, planes, bricks in use, and the whole hash table
  std::size_t reserved_bytes = 0;  ///< what the pools may grow to
};

/// Keys of blocks that were written or erased as a whole, for a twin that keeps a copy of the map. Room for a fixed
/// number; when it runs out, everything counts as changed.
struct BlockJournal {
  explicit BlockJournal(std::size_t room) : keys(room) {}
  void note(BlockKey key) {
    if (count > 0 && keys[count - 1] == key) return;
    if (count < keys.size()) {
      keys[count++] = key;
    } else {
      everything = true;
    }
  }
  void clear() {
    count = 0;
    everything = false;
  }
  ReservedArray<BlockKey> keys;
  std::size_t count = 0;
  bool everything = false;
};

class VoxelMap {
 public:
  VoxelMap(Grid grid, MapCapacity capacity);
  VoxelMap(const VoxelMap&) = delete;
  VoxelMap& operator=(const VoxelMap&) = delete;

  [[nodiscard]] const Grid& grid() const { return grid_; }
  [[nodiscard]] const MapCapacity& capacity() const { return capacity_; }

  // Reading (writer's thread, or while nobody writes)
  [[nodiscard]] Rgbo at(MCode code) const;  ///< kUnknownRgbo where nothing is known; spare bits zero
  [[nodiscard]] Rgbo at(const VoxelIndex& v) const { return is_inside_grid(v) ? at(encode(v)) : kUnknownRgbo; }
  /// False and all unknown if there is no such block. Spare bits zero, RGB zero unless occupied and coloured.
  bool read_block(BlockKey key, BlockValues& out) const;
  /// Like read_block, but with kHasColourBit in the codes: what the native file keeps.
  bool read_stored_block(BlockKey key, BlockValues& out) const;
  /// Like read_stored_block, from any thread while the writer works: retries until it saw one consistent state.
  bool copy_block(std::uint32_t slot, BlockKey& key, BlockValues& out) const;
  [[nodiscard]] std::uint32_t block_count() const { return headers_.in_use(); }
  /// What the pools still have to give.
  [[nodiscard]] MapCapacity available() const {
    return {headers_.available(), planes_.available(), bricks_.available()};
  }
  /// Keys of all blocks that hold at least one known voxel, ascending. Allocates: not for the frame loop.
  [[nodiscard]] std::vector<BlockKey> sorted_keys() const;
  [[nodiscard]] MapCounts counts() const;
  [[nodiscard]] MapMemory memory() const;

  // Writing whole blocks (files, merging, paging). False if a pool is full; the map is then as before.
  // Codes may carry kHasColourBit; without it a voxel counts as coloured if it is occupied and RGB != 0.
  bool write_block(BlockKey key, const BlockValues& values);
  /// Forgets a block and gives its memory back. False if there was none.
  bool erase_block(BlockKey key);
  void clear();
  /// Has the system provide the hash table and the first part of every pool now. For a map that frames will fill.
  void touch();
  /// From now on write_block(), erase_block() and clear() are noted there; nullptr: nowhere.
  void set_journal(BlockJournal* journal) { journal_ = journal; }

  // For integrators: slots are stable until erase_block().
  [[nodiscard]] std::uint32_t find(BlockKey key) const;
  /// Brings the place where find() will look closer.
  void prefetch(BlockKey key) const;
  /// kNoSlot when the pool is full. A new block is uniform unknown.
  std::uint32_t find_or_insert(BlockKey key);
  [[nodiscard]] BlockHeader& header(std::uint32_t slot) { return headers_[slot]; }
  [[nodiscard]] const BlockHeader& header(std::uint32_t slot) const { return headers_[slot]; }
  [[nodiscard]] LevelPlane& plane(std::uint32_t index) { return planes_[index]; }
  [[nodiscard]] const LevelPlane& plane(std::uint32_t index) const { return planes_[index]; }
  [[nodiscard]] ColourBrick& brick(std::uint32_t index) { return bricks_[index]; }
  [[nodiscard]] const ColourBrick& brick(std::uint32_t index) const { return bricks_[index]; }
  /// Gives a uniform block its own plane, filled with its level. False if the pool is full.
  bool make_dense(BlockHeader& header);
  /// Gives the brick `index` (0..7) of a block its colours, zeroed. False if the pool is full.
  bool make_brick(BlockHeader& header, int index);
  /// Turns a dense block whose 512 levels are equal and colourless into one word. Returns whether it did.
  bool make_uniform_if_equal(BlockHeader& header);
  void release_bricks_without_colour(BlockHeader& header);
  /// Exclusive upper bound of slots ever handed out; slots below may be free (header.key == kNoKey).
  [[nodiscard]] std::uint32_t slot_end() const { return headers_.high_water(); }
  static constexpr BlockKey kNoKey = ~BlockKey{0};

 private:
  void read_levels(const BlockHeader& header, BlockValues& out) const;
  [[nodiscard]] std::uint32_t table_place(BlockKey key) const;

  Grid grid_;
  MapCapacity capacity_;
  std::uint32_t table_mask_ = 0;
  ReservedArray<std::uint32_t> table_;  ///< slot + 1, 0 = empty; linear probing, at most three quarters full
  SlotPool<BlockHeader> headers_;
  SlotPool<LevelPlane> planes_;
  SlotPool<ColourBrick> bricks_;
  BlockJournal* journal_ = nullptr;
};

/// Level and colour of one voxel inside a block, in stored form (with kHasColourBit).
[[nodiscard]] Rgbo stored_value(const VoxelMap& map, const BlockHeader& header, int place);

}  // namespace g3d::mapper
