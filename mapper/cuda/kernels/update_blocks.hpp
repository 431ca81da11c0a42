// SPDX-License-Identifier: Apache-2.0
// Evidence of one frame -> levels and colours: a team of warps for each block of the map. Each warp has some of its
// eight bricks, each lane two neighbours in each of these, so that what holds for a brick holds for a whole warp.
// Blocks, planes and bricks are handed out and given back on the way, so that a block's form follows from its values.
#pragma once

#include "mapper/cuda/kernels/find_blocks.hpp"
#include "mapper/cuda/kernels/update_voxels.hpp"

namespace g3d::mapper::cuda {

/// How a block is dealt out to the threads of its team.
template <int kWarps>
struct Deal {
  static constexpr int kThreads = 32 * kWarps;
  static constexpr int kBricksHere = kBricks / kWarps;  ///< of a warp
  [[nodiscard]] static constexpr int brick_of(int t, int j) { return t / 32 * kBricksHere + j; }
  [[nodiscard]] static constexpr int place_of(int t, int j) { return brick_of(t, j) * kBrickSize + t % 32 * 2; }
};

/// Reads a thread's voxels. All looks before the first use: one wait instead of many.
template <int kWarps>
inline G3D_GPU void load_voxels(const Memory& m, const WorkItem& item, UpdateState& s, int t) {
  using D = Deal<kWarps>;
  const auto* stored = reinterpret_cast<const AnyHalf*>(m.planes + static_cast<std::size_t>(item.plane) * kVoxels);
  std::uint32_t pairs[D::kBricksHere];
#pragma GCC unroll 8
  for (int j = 0; j < D::kBricksHere; ++j) {
    pairs[j] = item.plane != kNone ? stored[D::place_of(t, j) / 2] : item.uniform_level * 0x0101U;
  }
  if (item.record != kNone) {
    std::uint32_t* record = m.hits + static_cast<std::size_t>(item.record) * kVoxels;
    AnyPair hits[D::kBricksHere];
#pragma GCC unroll 8
    for (int j = 0; j < D::kBricksHere; ++j) hits[j] = *reinterpret_cast<const AnyPair*>(record + D::place_of(t, j));
#pragma GCC unroll 8
    for (int j = 0; j < D::kBricksHere; ++j) {
      *reinterpret_cast<AnyPair*>(s.hits + D::place_of(t, j)) = hits[j];
      if ((hits[j].low & hits[j].high) == kNoHit) continue;
      *reinterpret_cast<AnyPair*>(record + D::place_of(t, j)) = {kNoHit, kNoHit};
    }
  }
#pragma GCC unroll 8
  for (int j = 0; j < D::kBricksHere; ++j) s.pairs[D::place_of(t, j) / 2] = static_cast<std::uint16_t>(pairs[j]);
}

/// Says what becomes of all voxels.
template <int kWarps>
inline G3D_GPU void look_at_voxels(const Team<kWarps>& team, const Memory& m, const FrameParams& f,
                                   const WorkItem& item, std::uint32_t block_id, const Corner& corner, UpdateState& s) {
  using D = Deal<kWarps>;
  PerThread<std::uint32_t, D::kThreads> summary;
  PerThread<std::uint32_t, D::kThreads> all;   // bits that all bytes have, for both of a pair
  PerThread<std::uint32_t, D::kThreads> some;  // that some have
  PerThread<std::uint32_t, D::kThreads> is_touched;
  PerThread<std::uint32_t, D::kThreads> is_coloured;
  PerThread<std::uint32_t, D::kThreads> bricks;  // touched | coloured << 8
  const ProjectedBlock block = project_block(f, corner);
  team.lanes([&](int t) {
    summary[t] = 0;
    all[t] = 0xFFFFU;
    some[t] = 0;
    bricks[t] = 0;
  });
#pragma GCC unroll 1
  for (int j = 0; j < D::kBricksHere; ++j) {
    team.lanes([&](int t) {
      const int number = D::brick_of(t, j);
      const std::uint32_t choice = (number < 4 ? item.choices[0] : item.choices[1]) >> (8 * (number % 4)) & 0xFFU;
      VoxelPair pair;
      pair.place = D::place_of(t, j);
      pair.old = s.pairs[pair.place / 2];
      pair.hit[0] = item.record != kNone ? s.hits[pair.place] : kNoHit;
      pair.hit[1] = item.record != kNone ? s.hits[pair.place + 1] : kNoHit;
      pair.view = static_cast<View>(choice & 3U);
      std::uint32_t bytes = pair.old;
      std::uint32_t found = 0;
      if (pair.view != View::hidden || item.record != kNone) {
        bytes = updated_pair(f, m, block_id, block, choice >> 2, pair, found);
        if (bytes != pair.old) s.pairs[pair.place / 2] = static_cast<std::uint16_t>(bytes);
      }
      const std::uint32_t in_the_end = coloured_pair(pair, bytes);
      summary[t] |= found;
      all[t] &= in_the_end;
      some[t] |= in_the_end;
      is_touched[t] = found;
      is_coloured[t] = in_the_end & (kHasColourBit * 0x0101U);
    });
    team.lanes([&](int t) {
      const std::uint32_t bit = 1U << D::brick_of(t, j);
      bricks[t] |= (is_touched.ballot(t) != 0 ? bit : 0U) | (is_coloured.ballot(t) != 0 ? bit << 8 : 0U);
    });
  }
  PerThread<std::uint32_t, D::kThreads> is_other;
  team.lanes([&](int t) {
    const std::uint32_t has = (some[t] | some[t] >> 8) & 0xFFU;
    const std::uint32_t lacks = ~(all[t] & all[t] >> 8) & 0xFFU;
    some[t] = has | lacks << 8;
    is_touched[t] = summary[t] & kAnyChange;
    is_coloured[t] = summary[t] & kAnyColour;
  });
  team.lanes([&](int t) { is_other[t] = some[t] != some.of(t, 0) ? 1 : 0; });
  team.each([&](int t) {
    std::uint32_t told = is_other.ballot(t) != 0 ? 0xFFFFU : some[t];
    told |= (is_touched.ballot(t) != 0 ? kAnyChange : 0U) | (is_coloured.ballot(t) != 0 ? kAnyColour : 0U);
    if (t % 32 == 0) atomic_or(&s.summary, told);
    if (t % 32 == 1 && bricks[t] != 0) atomic_or(&s.touched_bricks, bricks[t] & 0xFFU);
    if (t % 32 == 2 && bricks[t] != 0) atomic_or(&s.coloured_bricks, bricks[t] >> 8);
  });
}

/// What is to become of the block.
struct Outcome {
  bool changes;  ///< else nothing is written
  bool uniform;
};
inline G3D_GPU Outcome outcome_of(const UpdateState& s) {
  return {(s.summary & (kAnyChange | kAnyColour)) != 0,
          (s.summary & s.summary >> 8 & 0xFFU) == 0 && s.coloured_bricks == 0};
}

/// Takes what is missing, each piece by a thread of its own and all at once: each is a long wait.
inline G3D_GPU void take_memory(const Memory& m, const WorkItem& item, std::uint64_t key, std::uint32_t share,
                                UpdateState& s, int t) {
  if (t > kBricks + 1) return;
  MapState& map = *m.state;
  const bool is_brick = t < kBricks;
  const bool is_plane = t == kBricks;
  const std::uint32_t old = is_brick ? s.old_bricks[t] : is_plane ? item.plane : item.slot;
  const bool needed = is_brick ? (s.coloured_bricks >> t & 1U) != 0 : !is_plane || !outcome_of(s).uniform;
  std::uint32_t slot = old;
  if (needed && old == kNone) {
    slot = take(is_brick   ? map.bricks
                : is_plane ? map.planes
                           : map.blocks,
                is_brick   ? m.free_bricks
                : is_plane ? m.free_planes
                           : m.free_blocks,
                share);
    if (!is_brick && !is_plane && slot != kNone) write_new_block(m, key, slot, kUnknownLevel);
  }
  (is_brick ? s.bricks[t] : is_plane ? s.plane : s.slot) = slot;
}

/// Enters in the map what was taken and gives back what is no longer needed; all of it if a pool was full.
inline G3D_GPU void enter_memory(const Memory& m, const WorkItem& item, std::uint64_t key, UpdateState& s,
                                 bool complete, bool uniform, int t) {
  MapState& map = *m.state;
  if (t < kBricks) {
    const std::uint32_t old = s.old_bricks[t];
    const bool wanted = (s.coloured_bricks >> t & 1U) != 0;
    const std::uint32_t next = wanted ? s.bricks[t] : kNone;
    if (complete && (next != old || item.slot == kNone)) m.blocks[s.slot].bricks[t] = next;
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
  if (s.plane != item.plane) give_back(map.planes, m.returned_planes, s.plane);
  if (s.slot != item.slot) (void)erase_block(m, key);
}

inline G3D_GPU std::uint32_t pixel_rgb(const Memory& m, std::uint32_t pixel) {
  const std::uint8_t* rgb = m.rgb + 3 * static_cast<std::size_t>(pixel);
  return static_cast<std::uint32_t>(rgb[0]) | static_cast<std::uint32_t>(rgb[1]) << 8 |
         static_cast<std::uint32_t>(rgb[2]) << 16;
}

template <int kWarps>
inline G3D_GPU void write_voxels(const Memory& m, const WorkItem& item, UpdateState& s, int t) {
  using D = Deal<kWarps>;
  const bool any_colours = (s.summary & kAnyColour) != 0;
  for (int j = 0; j < D::kBricksHere; ++j) {
    const bool touched = (s.touched_bricks >> D::brick_of(t, j) & 1U) != 0;
    if (!touched && item.plane != kNone) continue;
    const int first = D::place_of(t, j);
    const std::uint32_t brick = s.bricks[D::brick_of(t, j)];
    std::uint32_t bytes = s.pairs[first / 2];
    for (int i = 0; i < 2 && touched && any_colours && brick != kNone; ++i) {
      const std::uint32_t byte = byte_of(bytes, i);
      const std::uint32_t hit = s.hits[first + i];
      if (hit >= kNoColour || (byte & kLevelMask) <= kUnknownLevel) continue;
      std::uint32_t& colour = m.colours[static_cast<std::size_t>(brick) * kBrickSize + (first + i) % kBrickSize];
      const std::uint32_t fresh = pixel_rgb(m, hit);
      const bool had_colour = (byte & kHasColourBit) != 0;
      const std::uint32_t next = had_colour ? blend_rgb(colour, fresh) : fresh;
      if (!had_colour || next != colour) atomic_or(&s.recoloured, 1U);
      colour = next;
      bytes |= static_cast<std::uint32_t>(kHasColourBit) << (8 * i);
    }
    auto* stored = reinterpret_cast<AnyHalf*>(m.planes + static_cast<std::size_t>(s.plane) * kVoxels);
    stored[first / 2] = static_cast<std::uint16_t>(bytes);
  }
}

/// kNone, or the block's slot if it changed.
template <int kWarps>
inline G3D_GPU std::uint32_t update_block(const Team<kWarps>& team, const Memory& m, const FrameParams& f,
                                          UpdateState& s, const WorkItem& item) {
  const int bx = static_cast<int>(item.where & 1023U);
  const int by = static_cast<int>(item.where >> 10 & 1023U);
  const int bz = static_cast<int>(item.where >> 20);
  const std::uint32_t block_id = block_id_at(f, bx, by, bz);
  const Corner corner = corner_of(f, bx, by, bz);
  team.each([&](int t) {
    if (t == 0) s.summary = 0;
    if (t == 1) s.touched_bricks = 0;
    if (t == 2) s.coloured_bricks = 0;
    if (t == 3) s.recoloured = 0;
    if (t < kBricks) s.old_bricks[t] = item.slot != kNone ? m.blocks[item.slot].bricks[t] : kNone;
    load_voxels<kWarps>(m, item, s, t);
  });
  look_at_voxels<kWarps>(team, m, f, item, block_id, corner, s);
  const Outcome outcome = outcome_of(s);
  std::uint32_t changed = kNone;
  if (outcome.changes) {
    const std::uint64_t key = block_key_at(f, bx, by, bz);
    const std::uint32_t share = static_cast<std::uint32_t>(team.index) % kShares;
    team.each([&](int t) { take_memory(m, item, key, share, s, t); });
    const bool complete = s.slot != kNone && (outcome.uniform || s.plane != kNone);
    team.each([&](int t) {
      enter_memory(m, item, key, s, complete, outcome.uniform, t);
      if (complete && !outcome.uniform) write_voxels<kWarps>(m, item, s, t);
    });
    if (complete && ((s.summary & kAnyChange) != 0 || s.recoloured != 0)) changed = s.slot;
  }
  team.each([&](int t) {
    if (t == 0 && item.record != kNone) m.record_of_block[block_id] = 0;
    if (!walks_rays(f.free_by) || static_cast<View>(item.view) == View::hidden || t >= 2 * kMarkWords) return;
    m.marks[static_cast<std::size_t>(block_id) * 2 * kMarkWords + static_cast<std::uint32_t>(t)] = 0;
    if (t == 0) m.marked_blocks[block_id] = 0;
  });
  return changed;
}

/// Changed blocks that the teams of a block have found, until they are noted together: one by one they would queue up
/// at the counter.
struct ChangedShares {
  std::uint32_t count[kUpdateThreads / 32];
  std::uint32_t first[kUpdateThreads / 32];
};
using ChangedSlots = PerThread<std::uint32_t, kUpdateThreads>;

/// A team's share of all work.
template <int kWarps>
inline G3D_GPU void update_share(const Team<kWarps>& team, const Memory& m, const FrameParams& f, UpdateState& s,
                                 std::uint32_t count, ChangedShares& changes, ChangedSlots& slots) {
  PerThread<std::uint32_t, 32 * kWarps> kept;
  PerThread<std::uint32_t, 32 * kWarps> first;
  int kept_count = 0;
  for (std::uint32_t i = static_cast<std::uint32_t>(team.index); i < count;
       i += static_cast<std::uint32_t>(team.count)) {
    const WorkItem item = m.items[i];
    const std::uint32_t changed = update_block<kWarps>(team, m, f, s, item);
    if (changed == kNone) continue;
    team.lanes([&](int t) {
      if (t == kept_count) kept[t] = changed;
    });
    if (++kept_count < 32) continue;
    team.lanes([&](int t) { first[t] = t == 0 ? atomic_add(&m.input->counters.changed, 32U) : 0; });
    team.lanes([&](int t) {
      const std::uint32_t place = first.of(t, 0) + static_cast<std::uint32_t>(t);
      if (t < 32) m.changed[place] = kept[t];
    });
    kept_count = 0;
  }
  team.lanes([&](int t) {
    if (t == 0) changes.count[team.in_block] = static_cast<std::uint32_t>(kept_count);
    if (t < kept_count) slots[32 * kWarps * team.in_block + t] = kept[t];
  });
}

template <int kWarps>
inline G3D_GPU void note_changed(const Block& block, const Memory& m, ChangedShares& changes, ChangedSlots& slots) {
  constexpr int kTeams = kUpdateThreads / 32 / kWarps;
  block.each([](int) {});
  block.each([&](int t) {
    if (t != 0) return;
    std::uint32_t sum = 0;
    for (int i = 0; i < kTeams; ++i) sum += changes.count[i];
    std::uint32_t first = sum != 0 ? atomic_add(&m.input->counters.changed, sum) : 0;
    for (int i = 0; i < kTeams; ++i) {
      changes.first[i] = first;
      first += changes.count[i];
    }
  });
  block.lanes([&](int t) {
    const int team = t / (32 * kWarps);
    const std::uint32_t i = static_cast<std::uint32_t>(t % (32 * kWarps));
    if (i < changes.count[team]) m.changed[changes.first[team] + i] = slots[t];
  });
}

}  // namespace g3d::mapper::cuda
