// SPDX-License-Identifier: Apache-2.0
// Where everything lies on the card: one allocation, cut into arrays by place(). The same function serves the helper
// (device addresses), the emulation (host addresses) and whoever only wants to know the size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "mapper/column_bits.hpp"
#include "mapper/cuda/align_memory.hpp"
#include "mapper/cuda/frame_params.hpp"
#include "mapper/grid_spread.hpp"
#include "mapper/look.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;
inline constexpr std::uint64_t kForgotten = ~std::uint64_t{0};  ///< table entry of a block that was erased
inline constexpr int kVoxels = 512;                             ///< of a block
inline constexpr int kBrickSize = 64;                           ///< voxels of a brick
inline constexpr int kBricks = 8;                               ///< of a block
inline constexpr int kMarkWords = 16;                           ///< one bit per voxel of a block

/// A block of the map. Its form follows from its values: a plane unless all are equal and colourless, a brick where
/// some voxel has a colour.
struct GpuBlock {
  std::uint64_t key;
  std::uint32_t plane;  ///< kNone: all 512 voxels have uniform_level
  std::uint32_t uniform_level;
  std::uint32_t bricks[kBricks];  ///< kNone: no voxel of the brick has a colour
};

/// A block that the frame may change.
struct alignas(32) WorkItem {
  std::uint32_t where;       ///< in the frame's box: x | y << 10 | z << 20
  std::uint32_t slot;        ///< kNone: not in the map yet
  std::uint32_t record;      ///< kNone: nothing was measured in it
  std::uint32_t view;        ///< View
  std::uint32_t choices[2];  ///< a byte for each brick: View | window's level << 2 | cells << 5
  std::uint32_t plane;       ///< as the frame found the block
  std::uint32_t uniform_level;
};

/// A share of the slots of one kind, `taken` counted from the last of the stack downwards, then from high_water
/// upwards. Frames tidy up at their start: what is given back during a launch can be taken from the next frame on.
struct alignas(128) GpuPool {
  std::uint32_t free_count;  ///< on the stack
  std::uint32_t high_water;
  std::uint32_t taken;
  std::uint32_t returned_count;
  std::uint32_t first;  ///< slot; the share's stacks begin there as well
  std::uint32_t capacity;
};

/// Atomic operations on one word come one after the other, some nanoseconds each: shares spread them over many words.
inline constexpr std::uint32_t kShares = 16;
struct GpuPools {
  GpuPool shares[kShares];
  std::uint32_t share_size;  ///< slots, but of the last ones
};

struct MapState {
  GpuPools blocks;
  GpuPools planes;
  GpuPools bricks;
  std::uint32_t refused_imports;  ///< blocks from the host for which there was no room, ever
};

/// A block on its way between the card and the host.
struct ParcelHead {
  std::uint64_t key;
  std::uint32_t plane;  ///< index among the parcel planes, kNone: uniform
  std::uint8_t uniform_level;
  std::uint8_t bricks;  ///< bit b: brick b follows
  std::uint8_t erase;   ///< to the card only: forget it
  std::uint8_t reserved;
  std::uint32_t first_brick;  ///< index among the parcel bricks
  std::uint32_t reserved2;
};
struct ParcelPlane {
  std::uint8_t levels[kVoxels];  ///< stored bytes, with kHasColourBit
};
struct ParcelBrick {
  std::uint8_t rgb[3 * kBrickSize];
};

/// Parcels of one direction; in memory that host and card share.
struct Parcels {
  ParcelHead* heads;
  ParcelPlane* planes;
  ParcelBrick* bricks;
};

/// What navigation asks of a changed block: which of its voxels are unknown, free or occupied.
struct ClassHead {
  std::uint64_t key;
  std::uint32_t uniform;  ///< class of all voxels, kNone: they differ
  std::uint32_t reserved;
};
struct ClassPlane {
  std::uint32_t words[kVoxels / 16];  ///< 2 bits for each voxel: 0 unknown, 1 free, 2 occupied
};
struct Classes {
  ClassHead* heads;
  ClassPlane* planes;  ///< same index
};

/// Questions and their answers, between frames; as many of each in one go as MemorySizes says.
struct Queries {
  BulkRay* rays;
  BulkHit* ray_hits;  ///< same index
  Look* looks;        ///< each comes back with its gain
};

/// Of changed blocks, whoever they are told to: see mapper::ChangedColumns.
struct Columns {
  std::uint64_t* keys;  ///< kForgotten: its layer does not matter
  std::uint8_t* cells;
};

/// A question about a grid, and its answer.
struct GridQuestion {
  GridSpread* spread;
  std::uint8_t* costs;
  std::uint32_t* distances;  ///< kNotReached, or at most max_cost
};

struct Memory {
  // Copied from the host for every frame, in one piece
  FrameInput* input;
  std::uint16_t* depth;
  std::uint8_t* rgb;
  // The sensor's, copied once, in one piece
  float* column_slope;
  float* row_slope;
  std::uint16_t* mask;
  // Images
  std::uint16_t* ends[kImageLevels];       ///< level 0: ray ends; above: maxima of 2x2 cells. Padded
  std::uint16_t* strong[kImageLevels];     ///< the same of measured rays alone; level 0 follows from ends and depth
  std::uint16_t* four[kImageLevels];       ///< maxima over windows of 4x4 cells that begin there
  std::uint16_t* two;                      ///< 2x2, of level 0
  std::uint32_t* pyramid[kPyramidLevels];  ///< minimum | maximum << 16
  std::uint32_t* tile_kinds;               ///< of each tile of readings, see kind_of(): 4 words
  // Hits
  std::uint32_t* pixel_block;  ///< block of the box in which a pixel's reading lies, kNone without one up to far_raw
  std::uint16_t* pixel_code;   ///< see HitTile
  std::uint32_t* record_of_block;  ///< index + 1; 0 = none
  std::uint32_t* hits;             ///< 512 per record: see hits.hpp. All ones between frames
  // Rays
  std::uint32_t* marks;         ///< weak and strong bits of each block of the box. Zero between frames
  std::uint8_t* marked_blocks;  ///< 1 where a ray has marked
  // Work
  WorkItem* items;
  std::uint32_t* changed;  ///< slots
  // The map
  MapState* state;
  std::uint32_t table_mask;
  std::uint64_t* table_keys;  ///< key + 1; 0 = empty, kForgotten. Linear probing
  std::uint32_t* table_slots;
  GpuBlock* blocks;
  std::uint8_t* planes;    ///< 512 stored bytes each
  std::uint32_t* colours;  ///< R | G << 8 | B << 16, 64 to a brick
  std::uint32_t* free_blocks;
  std::uint32_t* free_planes;
  std::uint32_t* free_bricks;
  std::uint32_t* returned_blocks;
  std::uint32_t* returned_planes;
  std::uint32_t* returned_bricks;
  // Questions
  ColumnTables* column_tables;
  std::uint64_t* column_keys;
  std::uint8_t* column_cells;
  BulkRay* rays;
  BulkHit* ray_hits;
  Look* looks;
  GridSpread* spread;
  std::uint8_t* grid_costs;
  std::uint32_t* grid_distances;
  std::uint32_t* awake[2];      ///< 1 for tiles to look at, of two rounds in turn
  std::uint32_t* awake_counts;  ///< of three rounds in turn
  std::uint32_t seen_stride;    ///< words of one look
  std::uint32_t* seen;          ///< a bit for each voxel of a look's box. Zero between questions
  AlignMemory align;
};

/// What the sizes of all arrays follow from.
struct MemorySizes {
  std::uint32_t width_px;
  std::uint32_t height_px;
  std::uint32_t box_blocks;  ///< no frame's box has more
  std::uint32_t walks_rays;  ///< 0: no marks are needed
  std::uint32_t blocks;      ///< capacity of the map
  std::uint32_t planes;
  std::uint32_t bricks;
  std::uint32_t rays = 0;           ///< cast in one go
  std::uint32_t looks = 0;          ///< counted in one go
  std::uint32_t columns = 0;        ///< blocks whose columns are read in one go
  std::uint32_t grid_cells = 0;     ///< of the largest grid that is asked about; 0: none is
  std::uint32_t surface_slots = 0;  ///< of the table of surfaces that frames are aligned to; 0: they are not
};

/// Slots of the hash table: at most half full.
[[nodiscard]] constexpr std::uint32_t table_size(std::uint32_t blocks) {
  std::uint32_t size = 32;
  while (size < 2 * static_cast<std::uint64_t>(blocks) && size < 0x80000000U) size *= 2;
  return size;
}

[[nodiscard]] constexpr GpuPools initial_pools(std::uint32_t capacity) {
  GpuPools pools{};
  pools.share_size = (capacity + kShares - 1) / kShares;
  if (pools.share_size == 0) pools.share_size = 1;
  std::uint32_t first = 0;
  for (GpuPool& share : pools.shares) {
    const std::uint32_t left = capacity - first;
    const std::uint32_t size = left < pools.share_size ? left : pools.share_size;
    share = {0, first, 0, 0, first, size};
    first += size;
  }
  return pools;
}
[[nodiscard]] constexpr MapState initial_state(const MemorySizes& s) {
  return {initial_pools(s.blocks), initial_pools(s.planes), initial_pools(s.bricks), 0};
}

[[nodiscard]] constexpr ImageShape level_shape(std::uint32_t width_px, std::uint32_t height_px, int level) {
  std::uint32_t w = width_px;
  std::uint32_t h = height_px;
  for (int l = 0; l < level; ++l) {
    w = (w + 1) / 2;
    h = (h + 1) / 2;
  }
  const std::uint32_t stride = (w + 2 * kPadding + 31) / 32 * 32;
  return {static_cast<std::int32_t>(w), static_cast<std::int32_t>(h), static_cast<std::int32_t>(stride),
          static_cast<std::int32_t>(h + 2 * kPadding)};
}

/// Tiles of 32 x 32 pixels.
[[nodiscard]] constexpr std::size_t tile_count(std::uint32_t width_px, std::uint32_t height_px) {
  return static_cast<std::size_t>((width_px + 31) / 32) * ((height_px + 31) / 32);
}

/// Every array begins at a multiple of this.
inline constexpr std::size_t kAlign_bytes = 256;
[[nodiscard]] constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + kAlign_bytes - 1) / kAlign_bytes * kAlign_bytes;
}

/// Cuts memory from `base` on into the arrays of `m`; returns the number of bytes in all.
template <typename Pointers>
std::size_t place(Pointers& m, const MemorySizes& s, std::uintptr_t base) {
  std::uintptr_t next = base;
  const auto take = [&next](auto*& array, std::size_t count) {
    using Pointer = std::remove_reference_t<decltype(array)>;
    array = reinterpret_cast<Pointer>(next);
    next += aligned(count * sizeof(*array));
  };
  const std::size_t pixels = static_cast<std::size_t>(s.width_px) * s.height_px;
  take(m.input, 1);
  take(m.depth, pixels);
  take(m.rgb, 3 * pixels);
  take(m.column_slope, s.width_px);
  take(m.row_slope, s.height_px);
  take(m.mask, pixels);
  for (int l = 0; l < kImageLevels; ++l) {
    const ImageShape shape = level_shape(s.width_px, s.height_px, l);
    const std::size_t cells = static_cast<std::size_t>(shape.stride) * static_cast<std::size_t>(shape.rows) + 64;
    take(m.ends[l], cells);
    take(m.strong[l], l > 0 ? cells : 0);
    take(m.four[l], cells);
    if (l == 0) take(m.two, cells);
    const std::size_t bare = static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height);
    if (l >= kBaseLevel) take(m.pyramid[l - kBaseLevel], bare);
  }
  take(m.tile_kinds, std::size_t{4} * tile_count(s.width_px, s.height_px));
  const std::size_t records = pixels < s.box_blocks ? pixels : s.box_blocks;
  take(m.pixel_block, pixels);
  take(m.pixel_code, pixels);
  take(m.record_of_block, s.box_blocks);
  take(m.marks, s.walks_rays != 0 ? std::size_t{s.box_blocks} * 2 * kMarkWords : 0);
  take(m.marked_blocks, s.walks_rays != 0 ? s.box_blocks : 0);
  take(m.items, s.box_blocks);
  take(m.changed, s.box_blocks);
  take(m.state, 1);
  m.table_mask = table_size(s.blocks) - 1;
  take(m.table_keys, table_size(s.blocks));
  take(m.table_slots, table_size(s.blocks));
  take(m.blocks, s.blocks);
  take(m.planes, std::size_t{s.planes} * kVoxels);
  take(m.colours, std::size_t{s.bricks} * kBrickSize);
  take(m.free_blocks, s.blocks);
  take(m.free_planes, s.planes);
  take(m.free_bricks, s.bricks);
  take(m.returned_blocks, s.blocks);
  take(m.returned_planes, s.planes);
  take(m.returned_bricks, s.bricks);
  take(m.column_tables, 1);
  take(m.column_keys, s.columns);
  take(m.column_cells, std::size_t{s.columns} * kBlockSide_cells * kBlockSide_cells);
  take(m.rays, s.rays);
  take(m.ray_hits, s.rays);
  take(m.looks, s.looks);
  take(m.spread, 1);
  take(m.grid_costs, s.grid_cells);
  take(m.grid_distances, s.grid_cells);
  for (auto& awake : m.awake) take(awake, s.grid_cells / 8 + 4);  // tiles of the narrowest grid
  take(m.awake_counts, 3);
  m.seen_stride = s.box_blocks * kSeenWords;
  take(m.seen, std::size_t{s.looks} * m.seen_stride);
  place_alignment(m.align, s.width_px, s.height_px, s.surface_slots, take);
  take(m.hits, records * kVoxels);  // last: the only array that does not begin as zeros
  return next - base;
}

/// From m.hits to the end: these bytes begin as 0xFF, all others as 0.
[[nodiscard]] constexpr std::size_t hits_bytes(const MemorySizes& s) {
  const std::size_t pixels = static_cast<std::size_t>(s.width_px) * s.height_px;
  const std::size_t records = pixels < s.box_blocks ? pixels : s.box_blocks;
  return records * kVoxels * sizeof(std::uint32_t);
}

}  // namespace g3d::mapper::cuda
