// SPDX-License-Identifier: Apache-2.0
// Evidence of one frame -> levels and colours: one block of threads for each block of the map, four voxels to a thread.
// Blocks, planes and bricks are handed out and given back on the way, so that a block's form follows from its values.
#pragma once

#include "mapper/cuda/kernels/find_blocks.hpp"
#include "mapper/cuda/kernels/hits.hpp"
#include "mapper/cuda/kernels/projection.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kAnyEvidence = 1U << 16;  ///< below: bits that some byte has, bits that some byte lacks
inline constexpr std::uint32_t kAnyChange = 1U << 17;
inline constexpr std::uint32_t kAnyColour = 1U << 18;

/// What the threads of one block tell each other.
struct UpdateState {
  WorkItem item;
  Corner corner;
  std::uint32_t views[kBricks];
  Window windows[kBricks];
  std::uint32_t summary;
  std::uint32_t coloured_bricks;  ///< bit b: some voxel of brick b has a colour
  std::uint32_t plane;
  std::uint32_t bricks[kBricks];
  std::uint32_t writes;
  std::uint32_t changed;
};

struct FourVoxels {
  std::uint32_t old_bytes;
  std::uint32_t new_bytes;
  std::uint32_t hits[4];
};

inline G3D_GPU std::uint32_t byte_of(std::uint32_t word, int k) { return word >> (8 * k) & 0xFFU; }

/// Sets bits that others mostly have set already.
inline G3D_GPU void join(std::uint32_t* shared, std::uint32_t bits) {
  if ((bits & ~*static_cast<volatile std::uint32_t*>(shared)) != 0) atomic_or(shared, bits);
}

/// See cpu/kernels/block_voxels.cpp, apply_block. `free`: 0, kWeakFree or kStrongFree.
inline G3D_GPU std::uint32_t updated_byte(const FrameParams& f, std::uint32_t old_byte, bool hit, std::uint32_t free) {
  const std::uint8_t level = static_cast<std::uint8_t>(old_byte & kLevelMask);
  const bool is_free = free == cpu::kStrongFree || (free != 0 && level <= kUnknownLevel);
  const std::uint32_t next = hit ? after_hit(level, steps_of(f)) : is_free ? after_miss(level, steps_of(f)) : level;
  return next | (next > kUnknownLevel ? old_byte & kHasColourBit : 0U);
}

inline G3D_GPU std::uint32_t free_by_marks(const Memory& m, std::uint32_t block_id, int place) {
  const std::uint32_t* words = m.marks + static_cast<std::size_t>(block_id) * 2 * kMarkWords + place / 32;
  const std::uint32_t bit = 1U << (place % 32);
  return (words[kMarkWords] & bit) != 0 ? cpu::kStrongFree : (words[0] & bit) != 0 ? cpu::kWeakFree : 0U;
}

inline G3D_GPU std::uint32_t free_by_projection(const FrameParams& f, const Memory& m, const UpdateState& s, int place,
                                                std::uint32_t level, bool hit) {
  const int brick = place / kBrickSize;
  const View view = static_cast<View>(s.views[brick]);
  if (view == View::hidden) return 0;
  const ProjectedBlock block = project_block(f, s.corner);
  if (view != View::all_free && !is_seen_through(f, m, block, s.windows[brick], view == View::look_at_border, place)) {
    return 0;
  }
  const bool contested = level > kUnknownLevel && !hit;
  return contested && is_strongly_free(f, m, block, s.windows[brick], place) ? cpu::kStrongFree : cpu::kWeakFree;
}

/// Reads a thread's voxels and says what becomes of their levels.
inline G3D_GPU void look_at_voxels(const FrameParams& f, const Memory& m, UpdateState& s, int t, FourVoxels& mine) {
  const GpuBlock& old = s.item.old;
  mine.old_bytes = old.uniform_level * 0x01010101U;
  if (old.plane != kNone) {
    mine.old_bytes =
        reinterpret_cast<const std::uint32_t*>(m.planes + static_cast<std::size_t>(old.plane) * kVoxels)[t];
  }
  std::uint32_t* record = nullptr;
  if (s.item.record != kNone) record = m.hits + static_cast<std::size_t>(s.item.record) * kVoxels + 4 * t;
  std::uint32_t summary = 0;
  mine.new_bytes = 0;
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    mine.hits[k] = kNoHit;
    if (record != nullptr) {
      mine.hits[k] = record[k];
      record[k] = kNoHit;
    }
    const bool hit = mine.hits[k] != kNoHit;
    const std::uint32_t old_byte = byte_of(mine.old_bytes, k);
    const std::uint32_t level = old_byte & kLevelMask;
    std::uint32_t free = 0;
    if (f.free_by == FreeBy::projection) {
      // Nothing can change where a voxel is as free as can be and was not hit.
      if (level != 0 && !hit) free = free_by_projection(f, m, s, 4 * t + k, level, hit);
    } else if (static_cast<View>(s.item.view) != View::hidden) {
      free = free_by_marks(m, s.item.block_id, 4 * t + k);
    }
    const std::uint32_t new_byte = updated_byte(f, old_byte, hit, free);
    const bool gets_colour = mine.hits[k] < kNoColour && (new_byte & kLevelMask) > kUnknownLevel;
    summary |= hit || free != 0 ? kAnyEvidence : 0U;
    summary |= new_byte != old_byte ? kAnyChange : 0U;
    summary |= gets_colour ? kAnyColour : 0U;
    const std::uint32_t final_byte = new_byte | (gets_colour ? kHasColourBit : 0U);
    summary |= final_byte | (~final_byte & 0xFFU) << 8;
    if ((final_byte & kHasColourBit) != 0) join(&s.coloured_bricks, 1U << (t / 16));
    mine.new_bytes |= new_byte << (8 * k);
  }
  join(&s.summary, summary);
}

/// By one thread: whether anything is written, and where. Memory is taken in the order plane, block, bricks, so that a
/// full pool leaves nothing half made.
inline G3D_GPU void provide_memory(const Memory& m, UpdateState& s) {
  s.writes = 0;
  s.changed = 0;
  s.plane = kNone;
  if ((s.summary & kAnyEvidence) == 0 || (s.summary & (kAnyChange | kAnyColour)) == 0) return;
  MapState& map = *m.state;
  const bool uniform = (s.summary & s.summary >> 8 & 0xFFU) == 0 && s.coloured_bricks == 0;
  s.plane = s.item.old.plane;
  if (!uniform && s.plane == kNone) s.plane = take(map.planes, m.free_planes);
  if (!uniform && s.plane == kNone) {
    atomic_add(&m.input->counters.refused, 1U);
    return;
  }
  if (s.item.slot == kNone) {
    s.item.slot = insert_block(m, s.item.old.key);
    if (s.item.slot == kNone) {
      if (s.plane != kNone) give_back(map.planes, m.returned_planes, s.plane);
      atomic_add(&m.input->counters.refused, 1U);
      return;
    }
  }
  GpuBlock& block = m.blocks[s.item.slot];
  if (uniform) {
    if (s.plane != kNone) give_back(map.planes, m.returned_planes, s.plane);
    s.plane = kNone;
    block.uniform_level = s.summary & kLevelMask;
  }
  block.plane = s.plane;
  bool all_bricks = true;
  for (int b = 0; b < kBricks; ++b) {
    std::uint32_t brick = s.item.old.bricks[b];
    const bool wanted = (s.coloured_bricks >> b & 1U) != 0;
    if (wanted && brick == kNone) {
      brick = take(map.bricks, m.free_bricks);
      all_bricks &= brick != kNone;
    } else if (!wanted && brick != kNone) {
      give_back(map.bricks, m.returned_bricks, brick);
      brick = kNone;
    }
    s.bricks[b] = brick;
    block.bricks[b] = brick;
  }
  if (!all_bricks) atomic_add(&m.input->counters.refused, 1U);  // the levels count all the same
  s.writes = 1;
  s.changed = s.summary & kAnyChange;
}

inline G3D_GPU std::uint32_t pixel_rgb(const Memory& m, std::uint32_t pixel) {
  const std::uint8_t* rgb = m.rgb + 3 * static_cast<std::size_t>(pixel);
  return static_cast<std::uint32_t>(rgb[0]) | static_cast<std::uint32_t>(rgb[1]) << 8 |
         static_cast<std::uint32_t>(rgb[2]) << 16;
}

inline G3D_GPU void write_voxels(const Memory& m, UpdateState& s, int t, const FourVoxels& mine) {
  std::uint32_t bytes = mine.new_bytes;
  const std::uint32_t brick = s.bricks[t / 16];
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const std::uint32_t byte = byte_of(bytes, k);
    if (brick == kNone || mine.hits[k] >= kNoColour || (byte & kLevelMask) <= kUnknownLevel) continue;
    std::uint32_t& colour = m.colours[static_cast<std::size_t>(brick) * kBrickSize + (4 * t + k) % kBrickSize];
    const std::uint32_t fresh = pixel_rgb(m, mine.hits[k]);
    const bool had_colour = (byte & kHasColourBit) != 0;
    const std::uint32_t next = had_colour ? blend_rgb(colour, fresh) : fresh;
    if (!had_colour || next != colour) join(&s.changed, kAnyChange);
    colour = next;
    bytes |= static_cast<std::uint32_t>(kHasColourBit) << (8 * k);
  }
  if (s.plane != kNone) {
    reinterpret_cast<std::uint32_t*>(m.planes + static_cast<std::size_t>(s.plane) * kVoxels)[t] = bytes;
  }
}

inline G3D_GPU void update_block(const Block& block, const Memory& m, const FrameParams& f, std::uint32_t index) {
  G3D_GPU_SHARED UpdateState s;
  PerThread<FourVoxels, kUpdateThreads> voxels;
  block.each([&](int t) {
    constexpr int kWords = sizeof(WorkItem) / sizeof(std::uint32_t);
    if (t < kWords) {
      reinterpret_cast<std::uint32_t*>(&s.item)[t] = reinterpret_cast<const std::uint32_t*>(m.items + index)[t];
    }
    if (t == kWords) s.summary = 0;
    if (t == kWords + 1) s.coloured_bricks = 0;
  });
  block.each([&](int t) {
    if (t >= kBricks || f.free_by != FreeBy::projection) return;
    const int id = static_cast<int>(s.item.block_id);
    const int row = id / f.blocks[0];
    const Corner corner = corner_of(f, id % f.blocks[0], row % f.blocks[1], row / f.blocks[1]);
    View view = static_cast<View>(s.item.view);
    const bool looks = view == View::look || view == View::look_at_border;
    if (looks) view = decide_brick(f, m, corner, {s.item.farthest_m, s.item.nearest_m}, t);
    s.views[t] = static_cast<std::uint32_t>(view);
    s.windows[t] = choose_window(f, f.units_per_metre * corner.z_m + f.middle_units[t]);
    if (t == 0) s.corner = corner;
  });
  block.each([&](int t) { look_at_voxels(f, m, s, t, voxels[t]); });
  block.each([&](int t) {
    if (t == 0) provide_memory(m, s);
  });
  block.each([&](int t) {
    if (s.writes != 0) write_voxels(m, s, t, voxels[t]);
    if (walks_rays(f.free_by) && t < 2 * kMarkWords && static_cast<View>(s.item.view) != View::hidden) {
      m.marks[static_cast<std::size_t>(s.item.block_id) * 2 * kMarkWords + static_cast<std::uint32_t>(t)] = 0;
      if (t == 0) m.marked_blocks[s.item.block_id] = 0;
    }
  });
  block.each([&](int t) {
    if (t != 0) return;
    if (s.changed != 0) m.changed[atomic_add(&m.input->counters.changed, 1U)] = s.item.slot;
    if (s.item.record != kNone) m.record_of_block[s.item.block_id] = 0;
  });
}

}  // namespace g3d::mapper::cuda
