// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/mirror.hpp"

#include <cstring>

namespace g3d::mapper::cuda {

static_assert(sizeof(ParcelPlane) == sizeof(LevelPlane) && sizeof(ParcelBrick) == sizeof(ColourBrick));
static_assert(kBricks == kBricksPerBlock && kBrickSize == kBrickVoxels && kVoxels == kBlockVoxels && kNone == kNoSlot);

namespace {

void forget_colours(LevelPlane& levels, int brick) {
  for (int i = brick * kBrickSize; i < (brick + 1) * kBrickSize; ++i) {
    levels[static_cast<std::size_t>(i)] &= kLevelMask;
  }
}

}  // namespace

Taken take_parcel(VoxelMap& map, const Parcels& parcels, std::uint32_t index, std::uint32_t frame_number) {
  const ParcelHead& head = parcels.heads[index];
  const bool is_new = map.find(head.key) == kNoSlot;
  const std::uint32_t slot = map.find_or_insert(head.key);
  if (slot == kNoSlot) return {kNoSlot, false};
  BlockHeader& header = map.header(slot);
  header.sequence.fetch_add(1, std::memory_order_acq_rel);
  if (head.plane == kNone) {
    if (header.plane == kNoSlot) {
      header.uniform_level = head.uniform_level;
    } else {
      map.plane(header.plane).fill(head.uniform_level);
      (void)map.make_uniform_if_equal(header);
    }
  } else if (map.make_dense(header)) {
    std::memcpy(map.plane(header.plane).data(), parcels.planes[head.plane].levels, kVoxels);
  } else {
    header.sequence.fetch_add(1, std::memory_order_release);
    if (is_new) map.erase_block(head.key);
    return {kNoSlot, false};
  }
  if (header.plane != kNoSlot) map.release_bricks_without_colour(header);
  std::uint32_t next = head.first_brick;
  bool complete = true;
  for (int b = 0; b < kBricks; ++b) {
    if ((head.bricks >> b & 1) == 0) continue;
    if (map.make_brick(header, b)) {
      std::memcpy(map.brick(header.bricks[static_cast<std::size_t>(b)]).data(), parcels.bricks[next].rgb,
                  sizeof(ColourBrick));
    } else {
      complete = false;
      if (header.plane != kNoSlot) forget_colours(map.plane(header.plane), b);
    }
    ++next;
  }
  if (!complete) (void)map.make_uniform_if_equal(header);
  header.changed_frame = frame_number;
  header.sequence.fetch_add(1, std::memory_order_release);
  return {slot, complete};
}

bool make_parcel(const VoxelMap& map, BlockKey key, const Parcels& parcels, std::uint32_t index) {
  const std::uint32_t slot = map.find(key);
  if (slot == kNoSlot) return false;
  ParcelHead& head = parcels.heads[index];
  head = {};
  head.key = key;
  head.plane = kNone;
  head.first_brick = index * kBricks;
  const BlockHeader& header = map.header(slot);
  head.uniform_level = header.uniform_level;
  if (header.plane != kNoSlot) {
    head.plane = index;
    std::memcpy(parcels.planes[index].levels, map.plane(header.plane).data(), kVoxels);
  }
  std::uint32_t next = head.first_brick;
  for (int b = 0; b < kBricks; ++b) {
    const std::uint32_t brick = header.bricks[static_cast<std::size_t>(b)];
    if (brick == kNoSlot) continue;
    head.bricks = static_cast<std::uint8_t>(head.bricks | 1U << b);
    std::memcpy(parcels.bricks[next++].rgb, map.brick(brick).data(), sizeof(ColourBrick));
  }
  return true;
}

}  // namespace g3d::mapper::cuda
