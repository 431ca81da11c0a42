// SPDX-License-Identifier: Apache-2.0
#include "mapper/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::mapper {
namespace {

// Fibonacci hashing: the multiplier is 2^64 / golden ratio; the high bits are the well mixed ones.
std::uint64_t mix(BlockKey key) {
  key *= 0x9E3779B97F4A7C15ULL;
  return key ^ (key >> 32);
}

constexpr bool is_coloured(Rgbo stored) { return (stored & kHasColourBit) != 0; }

// What a code means to the map: colour counts on occupied voxels alone.
Rgbo normalised(Rgbo value) {
  const Rgbo level = std::min<Rgbo>(value & kLevelMask, kMaxLevel);
  if (level <= kUnknownLevel) return level;
  const bool coloured = is_coloured(value) || (value & 0xFFFFFF00U) != 0;
  return coloured ? (value & 0xFFFFFF00U) | kHasColourBit | level : level;
}

// At most three quarters full when every block is in use: linear probing stays short.
std::uint32_t table_size(std::uint32_t blocks) {
  return std::bit_ceil(std::max<std::uint32_t>(blocks + blocks / 3U, 16U));
}

}  // namespace

MapCapacity capacity_for_bytes(std::size_t budget_bytes) {
  // Measured on furnished rooms at 2 cm: one block in three is dense, and a dense block has 1.3 colour bricks.
  constexpr double kBytesPerBlock = sizeof(BlockHeader) + 12.0 + 0.40 * sizeof(LevelPlane) + 0.55 * sizeof(ColourBrick);
  const double blocks = std::clamp(static_cast<double>(budget_bytes) / kBytesPerBlock, 64.0, 5.0e8);
  return {static_cast<std::uint32_t>(blocks), static_cast<std::uint32_t>(0.40 * blocks) + 8U,
          static_cast<std::uint32_t>(0.55 * blocks) + 8U};
}

VoxelMap::VoxelMap(Grid grid, MapCapacity capacity)
    : grid_(grid),
      capacity_(capacity),
      table_mask_(table_size(capacity.blocks) - 1),
      table_(table_size(capacity.blocks)),
      headers_(capacity.blocks),
      planes_(capacity.planes),
      bricks_(capacity.colour_bricks) {}

std::uint32_t VoxelMap::table_place(BlockKey key) const {
  std::uint32_t place = static_cast<std::uint32_t>(mix(key)) & table_mask_;
  while (table_[place] != 0 && headers_[table_[place] - 1].key != key) place = (place + 1) & table_mask_;
  return place;
}

std::uint32_t VoxelMap::find(BlockKey key) const { return table_[table_place(key)] - 1; }  // 0 - 1 == kNoSlot

void VoxelMap::prefetch(BlockKey key) const {
  __builtin_prefetch(&table_[static_cast<std::uint32_t>(mix(key)) & table_mask_]);
}

std::uint32_t VoxelMap::find_or_insert(BlockKey key) {
  const std::uint32_t place = table_place(key);
  if (table_[place] != 0) return table_[place] - 1;
  const std::uint32_t slot = headers_.take();
  if (slot == kNoSlot) return kNoSlot;
  BlockHeader& header = headers_[slot];
  header.sequence.fetch_add(1, std::memory_order_acq_rel);  // a reader may still hold the slot's former block
  header.key = key;
  header.plane = kNoSlot;
  header.bricks.fill(kNoSlot);
  header.changed_frame = 0;
  header.uniform_level = kUnknownLevel;
  header.sequence.fetch_add(1, std::memory_order_release);
  table_[place] = slot + 1;
  return slot;
}

bool VoxelMap::erase_block(BlockKey key) {
  std::uint32_t hole = table_place(key);
  if (table_[hole] == 0) return false;
  if (journal_ != nullptr) journal_->note(key);
  const std::uint32_t slot = table_[hole] - 1;
  BlockHeader& header = headers_[slot];
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  if (header.plane != kNoSlot) planes_.give_back(header.plane);
  for (const std::uint32_t brick : header.bricks) {
    if (brick != kNoSlot) bricks_.give_back(brick);
  }
  header.key = kNoKey;
  header.plane = kNoSlot;
  header.bricks.fill(kNoSlot);
  header.sequence.fetch_add(1, std::memory_order_release);
  headers_.give_back(slot);
  // Linear probing without tombstones: move up every later entry that may not stand behind the hole.
  for (std::uint32_t next = (hole + 1) & table_mask_; table_[next] != 0; next = (next + 1) & table_mask_) {
    const std::uint32_t home = static_cast<std::uint32_t>(mix(headers_[table_[next] - 1].key)) & table_mask_;
    if (((next - home) & table_mask_) < ((next - hole) & table_mask_)) continue;
    table_[hole] = table_[next];
    hole = next;
  }
  table_[hole] = 0;
  return true;
}

void VoxelMap::clear() {
  if (journal_ != nullptr) journal_->everything = true;
  table_.reset();
  headers_.reset();
  planes_.reset();
  bricks_.reset();
}

void VoxelMap::touch() {
  constexpr std::size_t kFirstPart_bytes = std::size_t{4} << 20;  // some seconds of a walk at 2 cm
  table_.touch(table_.size_bytes());
  headers_.touch(kFirstPart_bytes);
  planes_.touch(kFirstPart_bytes);
  bricks_.touch(kFirstPart_bytes);
}

bool VoxelMap::make_dense(BlockHeader& header) {
  if (header.plane != kNoSlot) return true;
  const std::uint32_t index = planes_.take();
  if (index == kNoSlot) return false;
  planes_[index].fill(header.uniform_level);
  header.plane = index;
  return true;
}

bool VoxelMap::make_brick(BlockHeader& header, int index) {
  std::uint32_t& brick = header.bricks[static_cast<std::size_t>(index)];
  if (brick != kNoSlot) return true;
  brick = bricks_.take();
  if (brick == kNoSlot) return false;
  bricks_[brick].fill(0);
  return true;
}

bool VoxelMap::make_uniform_if_equal(BlockHeader& header) {
  if (header.plane == kNoSlot) return true;
  const LevelPlane& levels = planes_[header.plane];
  if ((levels[0] & kHasColourBit) != 0) return false;
  if (std::memcmp(levels.data(), levels.data() + 1, kBlockVoxels - 1) != 0) return false;
  header.uniform_level = levels[0];
  planes_.give_back(header.plane);
  header.plane = kNoSlot;
  release_bricks_without_colour(header);
  return true;
}

void VoxelMap::release_bricks_without_colour(BlockHeader& header) {
  for (int b = 0; b < kBricksPerBlock; ++b) {
    std::uint32_t& brick = header.bricks[static_cast<std::size_t>(b)];
    if (brick == kNoSlot) continue;
    std::uint8_t seen = 0;
    if (header.plane != kNoSlot) {
      const std::uint8_t* levels = planes_[header.plane].data() + b * kBrickVoxels;
      for (int i = 0; i < kBrickVoxels; ++i) seen |= levels[i];
    }
    if ((seen & kHasColourBit) != 0) continue;
    bricks_.give_back(brick);
    brick = kNoSlot;
  }
}

Rgbo stored_value(const VoxelMap& map, const BlockHeader& header, int place) {
  if (header.plane == kNoSlot) return header.uniform_level;
  const Rgbo byte = map.plane(header.plane)[static_cast<std::size_t>(place)];
  if ((byte & kHasColourBit) == 0) return byte;
  const std::uint32_t brick = header.bricks[static_cast<std::size_t>(place / kBrickVoxels)];
  if (brick == kNoSlot) return byte;  // only a torn concurrent read can see this; copy_block() then retries
  const std::uint8_t* rgb = map.brick(brick).data() + 3 * (place % kBrickVoxels);
  return make_rgbo(rgb[0], rgb[1], rgb[2], 0) | byte;
}

Rgbo VoxelMap::at(MCode code) const {
  const std::uint32_t slot = find(code >> kBlockShift);
  if (slot == kNoSlot) return kUnknownRgbo;
  return published(stored_value(*this, headers_[slot], static_cast<int>(code & kPlaceMask)));
}

void VoxelMap::read_levels(const BlockHeader& header, BlockValues& out) const {
  if (header.plane == kNoSlot) {
    out.fill(header.uniform_level);
    return;
  }
  const LevelPlane& levels = planes_[header.plane];
  for (std::size_t i = 0; i < levels.size(); ++i) out[i] = levels[i];
  for (std::size_t b = 0; b < kBricksPerBlock; ++b) {
    if (header.bricks[b] == kNoSlot) continue;
    const std::uint8_t* rgb = bricks_[header.bricks[b]].data();
    for (std::size_t i = b * kBrickVoxels; i < (b + 1) * kBrickVoxels; ++i, rgb += 3) {
      if ((out[i] & kHasColourBit) != 0) out[i] |= make_rgbo(rgb[0], rgb[1], rgb[2], 0);
    }
  }
}

bool VoxelMap::read_stored_block(BlockKey key, BlockValues& out) const {
  const std::uint32_t slot = find(key);
  if (slot == kNoSlot) {
    out.fill(kUnknownRgbo);
    return false;
  }
  read_levels(headers_[slot], out);
  return true;
}

bool VoxelMap::read_block(BlockKey key, BlockValues& out) const {
  const bool found = read_stored_block(key, out);
  for (Rgbo& value : out) value = published(value);
  return found;
}

bool VoxelMap::write_block(BlockKey key, const BlockValues& values) {
  Rgbo all = 0;
  for (const Rgbo value : values) all |= value;
  const bool may_be_coloured = (all & (0xFFFFFF00U | kHasColourBit)) != 0;
  BlockValues stored;
  if (may_be_coloured) {
    std::transform(values.begin(), values.end(), stored.begin(), normalised);
  } else {
    for (std::size_t i = 0; i < stored.size(); ++i) stored[i] = std::min<Rgbo>(values[i] & kLevelMask, kMaxLevel);
  }
  Rgbo differs = stored[0] & kHasColourBit;
  std::array<bool, kBricksPerBlock> needed{};
  for (std::size_t b = 0; b < kBricksPerBlock; ++b) {
    Rgbo in_brick = 0;
    for (std::size_t i = b * kBrickVoxels; i < (b + 1) * kBrickVoxels; ++i) {
      differs |= stored[i] ^ stored[0];
      in_brick |= stored[i];
    }
    needed[b] = is_coloured(in_brick);
  }
  const bool uniform = differs == 0;

  // Everything is counted before anything is taken: a full pool must leave the map as it was.
  const std::uint32_t old_slot = find(key);
  std::uint32_t bricks_to_take = 0;
  for (int b = 0; b < kBricksPerBlock; ++b) {
    const auto i = static_cast<std::size_t>(b);
    if (needed[i] && (old_slot == kNoSlot || headers_[old_slot].bricks[i] == kNoSlot)) ++bricks_to_take;
  }
  const bool plane_to_take = !uniform && (old_slot == kNoSlot || headers_[old_slot].plane == kNoSlot);
  if ((old_slot == kNoSlot && headers_.available() == 0) || (plane_to_take && planes_.available() == 0) ||
      bricks_to_take > bricks_.available()) {
    return false;
  }

  if (journal_ != nullptr) journal_->note(key);
  BlockHeader& header = headers_[find_or_insert(key)];
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  if (uniform) {
    if (header.plane != kNoSlot) planes_.give_back(header.plane);
    header.plane = kNoSlot;
    header.uniform_level = static_cast<std::uint8_t>(stored[0]);
  } else {
    (void)make_dense(header);
    LevelPlane& levels = planes_[header.plane];
    for (std::size_t i = 0; i < stored.size(); ++i) levels[i] = static_cast<std::uint8_t>(stored[i]);
  }
  for (std::size_t i = 0; i < stored.size(); ++i) {
    if (!needed[i / kBrickVoxels]) {
      i += kBrickVoxels - 1;
      continue;
    }
    if (!is_coloured(stored[i])) continue;
    (void)make_brick(header, static_cast<int>(i / kBrickVoxels));
    std::uint8_t* rgb = bricks_[header.bricks[i / kBrickVoxels]].data() + 3 * (i % kBrickVoxels);
    rgb[0] = static_cast<std::uint8_t>(stored[i] >> 24);
    rgb[1] = static_cast<std::uint8_t>(stored[i] >> 16);
    rgb[2] = static_cast<std::uint8_t>(stored[i] >> 8);
  }
  release_bricks_without_colour(header);
  header.sequence.fetch_add(1, std::memory_order_release);
  return true;
}

// Not instrumented: it reads what the writer may be writing and keeps the copy only if the sequence proves it whole.
__attribute__((no_sanitize("thread"))) bool VoxelMap::copy_block(std::uint32_t slot, BlockKey& key,
                                                                 BlockValues& out) const {
  if (slot >= headers_.capacity()) return false;
  // The reader's own read-modify-write orders the copy before the second look at the counter.
  auto& sequence = const_cast<std::atomic<std::uint32_t>&>(headers_[slot].sequence);
  for (;;) {
    const std::uint32_t before = sequence.load(std::memory_order_acquire);
    if ((before & 1U) != 0) continue;
    if (before == 0) return false;  // never handed out
    BlockKey seen_key = 0;
    std::memcpy(&seen_key, &headers_[slot].key, sizeof seen_key);
    const std::uint32_t plane = headers_[slot].plane;
    const std::uint8_t level = headers_[slot].uniform_level;
    const auto bricks = headers_[slot].bricks;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (plane == kNoSlot || plane >= planes_.capacity()) {
        out[i] = level;
        continue;
      }
      const Rgbo byte = planes_[plane][i];
      const std::uint32_t brick = bricks[i / kBrickVoxels];
      if ((byte & kHasColourBit) == 0 || brick >= bricks_.capacity()) {
        out[i] = byte;
        continue;
      }
      const std::uint8_t* rgb = &bricks_[brick][3 * (i % kBrickVoxels)];
      out[i] = make_rgbo(rgb[0], rgb[1], rgb[2], 0) | byte;
    }
    if (sequence.fetch_add(0, std::memory_order_acq_rel) != before) continue;
    key = seen_key;
    return seen_key != kNoKey;
  }
}

std::vector<BlockKey> VoxelMap::sorted_keys() const {
  std::vector<BlockKey> keys;
  keys.reserve(block_count());
  for (std::uint32_t slot = 0; slot < slot_end(); ++slot) {
    const BlockHeader& header = headers_[slot];
    if (header.key == kNoKey) continue;
    if (header.plane == kNoSlot && header.uniform_level == kUnknownLevel) continue;
    if (header.plane != kNoSlot) {
      const LevelPlane& levels = planes_[header.plane];
      if (std::all_of(levels.begin(), levels.end(), [](std::uint8_t l) { return l == kUnknownLevel; })) continue;
    }
    keys.push_back(header.key);
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

MapCounts VoxelMap::counts() const {
  MapCounts counts;
  for (std::uint32_t slot = 0; slot < slot_end(); ++slot) {
    const BlockHeader& header = headers_[slot];
    if (header.key == kNoKey) continue;
    ++counts.blocks;
    if (header.plane == kNoSlot) {
      ++counts.uniform_blocks;
      if (header.uniform_level < kUnknownLevel) counts.free += kBlockVoxels;
      if (header.uniform_level > kUnknownLevel) counts.occupied += kBlockVoxels;
      continue;
    }
    for (const std::uint8_t byte : planes_[header.plane]) {
      const std::uint8_t level = byte & kLevelMask;
      if (level < kUnknownLevel) ++counts.free;
      if (level > kUnknownLevel) ++counts.occupied;
      if ((byte & kHasColourBit) != 0) ++counts.coloured;
    }
  }
  return counts;
}

MapMemory VoxelMap::memory() const {
  MapMemory memory;
  memory.used_bytes = table_.size_bytes() + headers_.in_use() * sizeof(BlockHeader) +
                      planes_.in_use() * sizeof(LevelPlane) + bricks_.in_use() * sizeof(ColourBrick);
  memory.reserved_bytes =
      table_.size_bytes() + headers_.reserved_bytes() + planes_.reserved_bytes() + bricks_.reserved_bytes();
  return memory;
}

}  // namespace g3d::mapper
