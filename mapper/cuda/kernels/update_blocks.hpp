// SPDX-License-Identifier: Apache-2.0
// Evidence of one frame -> levels and colours: one block of threads for each block of the map, eight voxels to a
// thread. Blocks, planes and bricks are handed out and given back on the way, so that a block's form follows from its
// values.
#pragma once

#include "mapper/cuda/kernels/find_blocks.hpp"
#include "mapper/cuda/kernels/hits.hpp"
#include "mapper/cuda/kernels/projection.hpp"
#include "mapper/cuda/kernels/walk_rays.hpp"

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
  std::uint32_t slot;
  std::uint32_t plane;
  std::uint32_t bricks[kBricks];
  std::uint32_t changed;
  std::uint32_t refused;
  // Each thread's own voxels
  std::uint16_t pairs[kVoxels / 2];  ///< two bytes each
  std::uint32_t hits[kVoxels];       ///< as in the record
};

/// A thread has two neighbours in each of two bricks; the 32 threads that run together have the same bricks, so that
/// what holds for a brick holds for all of them.
inline constexpr int kPairs = kVoxels / 2 / kUpdateThreads;
[[nodiscard]] constexpr int brick_of(int t, int pair) { return t / 32 * kPairs + pair; }
[[nodiscard]] constexpr int place_of(int t, int pair) { return brick_of(t, pair) * kBrickSize + t % 32 * 2; }

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
  const VoxelIndex v = decode(static_cast<MCode>(place));
  const std::uint32_t bit_place = mark_place(v.x, v.y, v.z);
  const std::uint32_t* words = m.marks + static_cast<std::size_t>(block_id) * 2 * kMarkWords + bit_place / 32;
  const std::uint32_t bit = 1U << (bit_place % 32);
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

/// Reads a thread's voxels. All looks before the first use: one wait instead of many.
inline G3D_GPU void load_voxels(const Memory& m, UpdateState& s, int t) {
  const GpuBlock& old = s.item.old;
  const auto* stored = reinterpret_cast<const AnyHalf*>(m.planes + static_cast<std::size_t>(old.plane) * kVoxels);
  std::uint32_t pairs[kPairs];
#pragma GCC unroll 4
  for (int i = 0; i < kPairs; ++i) {
    pairs[i] = old.plane != kNone ? stored[place_of(t, i) / 2] : old.uniform_level * 0x0101U;
  }
  if (s.item.record != kNone) {
    std::uint32_t* record = m.hits + static_cast<std::size_t>(s.item.record) * kVoxels;
    std::uint32_t hits[2 * kPairs];
#pragma GCC unroll 8
    for (int i = 0; i < 2 * kPairs; ++i) hits[i] = record[place_of(t, i / 2) + i % 2];
#pragma GCC unroll 8
    for (int i = 0; i < 2 * kPairs; ++i) {
      s.hits[place_of(t, i / 2) + i % 2] = hits[i];
      record[place_of(t, i / 2) + i % 2] = kNoHit;
    }
  }
#pragma GCC unroll 4
  for (int i = 0; i < kPairs; ++i) s.pairs[place_of(t, i) / 2] = static_cast<std::uint16_t>(pairs[i]);
}

/// Says what becomes of a thread's voxels.
inline G3D_GPU void look_at_voxels(const FrameParams& f, const Memory& m, UpdateState& s, int t) {
  load_voxels(m, s, t);
  const bool any_hits = s.item.record != kNone;
  std::uint32_t summary = 0;
#pragma GCC unroll 2
  for (int pair = 0; pair < kPairs; ++pair) {
    const int first = place_of(t, pair);
    std::uint32_t bytes = 0;
#pragma GCC unroll 2
    for (int i = 0; i < 2; ++i) {
      const std::uint32_t hit_word = any_hits ? s.hits[first + i] : kNoHit;
      const bool hit = hit_word != kNoHit;
      const std::uint32_t old_byte = byte_of(s.pairs[first / 2], i);
      const std::uint32_t level = old_byte & kLevelMask;
      std::uint32_t free = 0;
      if (f.free_by == FreeBy::projection) {
        // Nothing can change where a voxel is as free as can be and was not hit.
        if (level != 0 && !hit) free = free_by_projection(f, m, s, first + i, level, hit);
      } else if (static_cast<View>(s.item.view) != View::hidden) {
        free = free_by_marks(m, s.item.block_id, first + i);
      }
      const std::uint32_t new_byte = updated_byte(f, old_byte, hit, free);
      const bool gets_colour = hit_word < kNoColour && (new_byte & kLevelMask) > kUnknownLevel;
      summary |= hit || free != 0 ? kAnyEvidence : 0U;
      summary |= new_byte != old_byte ? kAnyChange : 0U;
      summary |= gets_colour ? kAnyColour : 0U;
      const std::uint32_t final_byte = new_byte | (gets_colour ? kHasColourBit : 0U);
      summary |= final_byte | (~final_byte & 0xFFU) << 8;
      if ((final_byte & kHasColourBit) != 0) join(&s.coloured_bricks, 1U << brick_of(t, pair));
      bytes |= new_byte << (8 * i);
    }
    s.pairs[first / 2] = static_cast<std::uint16_t>(bytes);
  }
  join(&s.summary, summary);
}

/// What is to become of the block.
struct Outcome {
  bool changes;  ///< else nothing is written
  bool uniform;
};
inline G3D_GPU Outcome outcome_of(const UpdateState& s) {
  const bool changes = (s.summary & kAnyEvidence) != 0 && (s.summary & (kAnyChange | kAnyColour)) != 0;
  return {changes, (s.summary & s.summary >> 8 & 0xFFU) == 0 && s.coloured_bricks == 0};
}

/// Takes what is missing, each piece by a thread of its own: one after the other they would take longer than all else.
inline G3D_GPU void take_memory(const Memory& m, UpdateState& s, int t) {
  const Outcome outcome = outcome_of(s);
  MapState& map = *m.state;
  if (t < kBricks) {
    const bool wanted = outcome.changes && (s.coloured_bricks >> t & 1U) != 0;
    const std::uint32_t old = s.item.old.bricks[t];
    s.bricks[t] = wanted && old == kNone ? take(map.bricks, m.free_bricks) : old;
  } else if (t == kBricks) {
    const bool wanted = outcome.changes && !outcome.uniform && s.item.old.plane == kNone;
    s.plane = wanted ? take(map.planes, m.free_planes) : s.item.old.plane;
  } else if (t == kBricks + 1) {
    s.slot = outcome.changes && s.item.slot == kNone ? insert_block(m, s.item.old.key) : s.item.slot;
    s.changed = outcome.changes ? s.summary & kAnyChange : 0U;
  }
}

/// Enters in the map what was taken and gives back what is no longer needed; all of it if a pool was full.
inline G3D_GPU void enter_memory(const Memory& m, UpdateState& s, bool complete, bool uniform, int t) {
  MapState& map = *m.state;
  if (t < kBricks) {
    const std::uint32_t old = s.item.old.bricks[t];
    const bool wanted = (s.coloured_bricks >> t & 1U) != 0;
    if (complete) m.blocks[s.slot].bricks[t] = wanted ? s.bricks[t] : kNone;
    if (complete ? !wanted && old != kNone : s.bricks[t] != old) give_back(map.bricks, m.returned_bricks, s.bricks[t]);
    return;
  }
  if (t != kBricks) return;
  const bool lacks_colour = [&] {
    for (int b = 0; b < kBricks; ++b) {
      if ((s.coloured_bricks >> b & 1U) != 0 && s.bricks[b] == kNone) return true;
    }
    return false;
  }();
  if (!complete || lacks_colour)
    atomic_add(&m.input->counters.refused, 1U);  // without colour levels count all the same
  if (complete) {
    GpuBlock& block = m.blocks[s.slot];
    if (uniform) block.uniform_level = s.summary & kLevelMask;
    block.plane = uniform ? kNone : s.plane;
    if (uniform && s.plane != kNone) give_back(map.planes, m.returned_planes, s.plane);
    return;
  }
  if (s.plane != s.item.old.plane) give_back(map.planes, m.returned_planes, s.plane);
  if (s.slot != s.item.slot) erase_block(m, s.item.old.key);
}

inline G3D_GPU std::uint32_t pixel_rgb(const Memory& m, std::uint32_t pixel) {
  const std::uint8_t* rgb = m.rgb + 3 * static_cast<std::size_t>(pixel);
  return static_cast<std::uint32_t>(rgb[0]) | static_cast<std::uint32_t>(rgb[1]) << 8 |
         static_cast<std::uint32_t>(rgb[2]) << 16;
}

inline G3D_GPU void write_voxels(const Memory& m, UpdateState& s, bool uniform, int t) {
  const bool any_colours = (s.summary & kAnyColour) != 0;
#pragma GCC unroll 4
  for (int pair = 0; pair < kPairs; ++pair) {
    const int first = place_of(t, pair);
    const std::uint32_t brick = s.bricks[brick_of(t, pair)];
    std::uint32_t bytes = s.pairs[first / 2];
    for (int i = 0; i < 2 && any_colours && brick != kNone; ++i) {
      const std::uint32_t byte = byte_of(bytes, i);
      const std::uint32_t hit = s.hits[first + i];
      if (hit >= kNoColour || (byte & kLevelMask) <= kUnknownLevel) continue;
      std::uint32_t& colour = m.colours[static_cast<std::size_t>(brick) * kBrickSize + (first + i) % kBrickSize];
      const std::uint32_t fresh = pixel_rgb(m, hit);
      const bool had_colour = (byte & kHasColourBit) != 0;
      const std::uint32_t next = had_colour ? blend_rgb(colour, fresh) : fresh;
      if (!had_colour || next != colour) join(&s.changed, kAnyChange);
      colour = next;
      bytes |= static_cast<std::uint32_t>(kHasColourBit) << (8 * i);
    }
    if (uniform) continue;
    auto* stored = reinterpret_cast<AnyHalf*>(m.planes + static_cast<std::size_t>(s.plane) * kVoxels);
    stored[first / 2] = static_cast<std::uint16_t>(bytes);
  }
}

inline G3D_GPU void update_block(const Block& block, const Memory& m, const FrameParams& f, std::uint32_t index) {
  G3D_GPU_SHARED UpdateState s;
  block.each([&](int t) {
    constexpr int kWords = sizeof(WorkItem) / sizeof(std::uint32_t);
    if (t < kWords) {
      reinterpret_cast<AnyWord*>(&s.item)[t] = reinterpret_cast<const AnyWord*>(m.items + index)[t];
    }
    if (t == kWords) s.summary = 0;
    if (t == kWords + 1) s.coloured_bricks = 0;
    if (t == kWords + 2) s.refused = 0;
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
    s.windows[t] = choose_window(f, m, f.units_per_metre * corner.z_m + f.middle_units[t]);
    if (t == 0) s.corner = corner;
  });
  block.each([&](int t) { look_at_voxels(f, m, s, t); });
  block.each([&](int t) { take_memory(m, s, t); });
  block.each([&](int t) {
    const Outcome outcome = outcome_of(s);
    const bool complete = s.slot != kNone && (outcome.uniform || s.plane != kNone);
    if (outcome.changes) enter_memory(m, s, complete, outcome.uniform, t);
    if (outcome.changes && complete) write_voxels(m, s, outcome.uniform, t);
    if (outcome.changes && !complete && t == 0) s.refused = 1;
    if (walks_rays(f.free_by) && t < 2 * kMarkWords && static_cast<View>(s.item.view) != View::hidden) {
      m.marks[static_cast<std::size_t>(s.item.block_id) * 2 * kMarkWords + static_cast<std::uint32_t>(t)] = 0;
      if (t == 0) m.marked_blocks[s.item.block_id] = 0;
    }
  });
  block.each([&](int t) {
    if (t != 0) return;
    if (s.changed != 0 && s.refused == 0) m.changed[atomic_add(&m.input->counters.changed, 1U)] = s.slot;
    if (s.item.record != kNone) m.record_of_block[s.item.block_id] = 0;
  });
}

}  // namespace g3d::mapper::cuda
