// SPDX-License-Identifier: Apache-2.0
// Evidence of one frame for a pair of neighbouring voxels -> their bytes. See cpu/kernels/block_voxels.cpp.
#pragma once

#include "mapper/cuda/kernels/hits.hpp"
#include "mapper/cuda/kernels/projection.hpp"
#include "mapper/cuda/kernels/walk_rays.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kAnyChange = 1U << 16;  ///< below: bits that some byte has, bits that some byte lacks
inline constexpr std::uint32_t kAnyColour = 1U << 17;

/// What the threads of a team tell each other about the block in hand.
struct alignas(16) UpdateState {
  std::uint32_t hits[kVoxels];       ///< as in the record; if there is one
  std::uint16_t pairs[kVoxels / 2];  ///< two bytes each
  std::uint32_t summary;
  std::uint32_t touched_bricks;   ///< bit b: some voxel of brick b changes or gets a colour
  std::uint32_t coloured_bricks;  ///< bit b: some voxel of brick b has a colour
  std::uint32_t recoloured;
  std::uint32_t slot;
  std::uint32_t plane;
  std::uint32_t bricks[kBricks];
  std::uint32_t old_bricks[kBricks];
};

inline G3D_GPU std::uint32_t byte_of(std::uint32_t word, int k) { return word >> (8 * k) & 0xFFU; }

/// `free`: bit 0, some ray passes; bit 2, a measured one.
inline G3D_GPU std::uint32_t updated_byte(const FrameParams& f, std::uint32_t old_byte, std::uint32_t hit,
                                          std::uint32_t free) {
  const std::uint8_t level = static_cast<std::uint8_t>(old_byte & kLevelMask);
  const bool is_free = hit == kNoHit && (free & (level <= kUnknownLevel ? 5U : 4U)) != 0;
  const std::uint32_t next = is_hit(hit) ? after_hit(level, steps_of(f))
                             : is_free   ? after_miss(level, steps_of(f))
                                         : level;
  return next | (next > kUnknownLevel ? old_byte & kHasColourBit : 0U);
}

/// Two neighbours along x, the first of them at an even place, and what is known of their surroundings.
struct VoxelPair {
  int place;             ///< M & 511 of the first
  std::uint32_t old;     ///< two bytes
  std::uint32_t hit[2];  ///< as in a record
  View view;             ///< of their brick; without projection: hidden or not
};

struct [[gnu::may_alias]] alignas(8) FloatPair {
  float first, second;
};
[[nodiscard]] inline G3D_GPU FloatPair pair_at(const float* table, int place) {
  return *reinterpret_cast<const FloatPair*>(table + place);
}

/// Marks of both: weak bits, strong bits << 2.
inline G3D_GPU std::uint32_t marks_of(const Memory& m, std::uint32_t block_id, int place) {
  const auto packed = [place](int axis) {
    return (place >> axis & 1) | (place >> (axis + 2) & 2) | (place >> (axis + 4) & 4);
  };
  const std::uint32_t bit = mark_place(packed(0), packed(1), packed(2));
  const std::uint32_t* words = m.marks + static_cast<std::size_t>(block_id) * 2 * kMarkWords + bit / 32;
  return (words[0] >> (bit % 32) & 3U) | (words[kMarkWords] >> (bit % 32) & 3U) << 2;
}

/// Which of a pair a ray passes, by projection: a bit each, strong ones << 2.
inline G3D_GPU std::uint32_t seen_through(const FrameParams& f, const Memory& m, const ProjectedBlock& block,
                                          std::uint32_t window_choice, const VoxelPair& pair) {
  const cpu::ProjectionTables& tables = m.input->tables.places;
  const Window window = window_of(f, m, window_choice);
  std::uint32_t seen = 3U;
  if (pair.view != View::all_free) {
    const FloatPair x = pair_at(tables.x_px_m, pair.place);
    const FloatPair y = pair_at(tables.y_px_m, pair.place);
    const FloatPair z = pair_at(tables.z_units, pair.place);
    const bool at_border = pair.view == View::look_at_border;
    seen = (is_seen_through(f, block, window, at_border, {x.first, y.first, z.first}) ? 1U : 0U) |
           (is_seen_through(f, block, window, at_border, {x.second, y.second, z.second}) ? 2U : 0U);
  }
  // Occupied voxels need a measured ray; they are few.
  std::uint32_t occupied = (pair.old & kLevelMask) > kUnknownLevel && pair.hit[0] == kNoHit ? 1U : 0U;
  occupied |= (pair.old >> 8 & kLevelMask) > kUnknownLevel && pair.hit[1] == kNoHit ? 2U : 0U;
#pragma GCC unroll 1
  for (std::uint32_t rest = seen & occupied; rest != 0; rest &= rest - 1) {
    const int i = (rest & 1U) != 0 ? 0 : 1;
    const VoxelOffset voxel{tables.x_px_m[pair.place + i], tables.y_px_m[pair.place + i],
                            tables.z_units[pair.place + i]};
    if (is_strongly_free(f, m, block, window, voxel)) seen |= 4U << i;
  }
  return seen;
}

/// What a pair becomes. Sets kAnyChange and kAnyColour in `summary` where they apply.
inline G3D_GPU std::uint32_t updated_pair(const FrameParams& f, const Memory& m, std::uint32_t block_id,
                                          const ProjectedBlock& block, std::uint32_t window_choice,
                                          const VoxelPair& pair, std::uint32_t& summary) {
  std::uint32_t free = 0;
  if (pair.view != View::hidden) {
    // Nothing can change where a voxel is as free as can be and was not hit.
    const bool first = (pair.old & kLevelMask) != 0 && pair.hit[0] == kNoHit;
    const bool second = (pair.old >> 8 & kLevelMask) != 0 && pair.hit[1] == kNoHit;
    if (walks_rays(f.free_by)) free = marks_of(m, block_id, pair.place);
    if (f.free_by == FreeBy::projection && (first || second)) free = seen_through(f, m, block, window_choice, pair);
  }
  // Most voxels are neither hit nor occupied: a byte is its level then, and a miss never makes 16 of it.
  const std::uint32_t low = pair.old & 0xFFU;
  const std::uint32_t high = pair.old >> 8;
  std::uint32_t bytes = 0;
  if ((pair.hit[0] & pair.hit[1]) == kNoHit && ((free & 4U) == 0 || low <= kUnknownLevel) &&
      ((free & 8U) == 0 || high <= kUnknownLevel)) {
    const std::uint32_t miss = f.miss_step;
    const std::uint32_t lowered = (free & 5U) != 0 && low <= kUnknownLevel ? most(low, miss) - miss : low;
    const std::uint32_t second_lowered = (free & 10U) != 0 && high <= kUnknownLevel ? most(high, miss) - miss : high;
    bytes = lowered | second_lowered << 8;
    summary = bytes != pair.old ? kAnyChange : 0U;
    return bytes;
  }
#pragma GCC unroll 1
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t hit = i == 0 ? pair.hit[0] : pair.hit[1];
    const std::uint32_t old_byte = byte_of(pair.old, i);
    const std::uint32_t new_byte = updated_byte(f, old_byte, hit, free >> i);
    summary |= new_byte != old_byte ? kAnyChange : 0U;
    summary |= hit < kNoColour && (new_byte & kLevelMask) > kUnknownLevel ? kAnyColour : 0U;
    bytes |= new_byte << (8 * i);
  }
  return bytes;
}

/// With the mark of a colour where one is due: what a pair is in the end, if there is memory for colours.
inline G3D_GPU std::uint32_t coloured_pair(const VoxelPair& pair, std::uint32_t bytes) {
  for (int i = 0; i < 2; ++i) {
    if (pair.hit[i] < kNoColour && (byte_of(bytes, i) & kLevelMask) > kUnknownLevel) {
      bytes |= static_cast<std::uint32_t>(kHasColourBit) << (8 * i);
    }
  }
  return bytes;
}

}  // namespace g3d::mapper::cuda
