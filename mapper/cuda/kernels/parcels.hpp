// SPDX-License-Identifier: Apache-2.0
// Blocks on their way between the card and the host's mirror, a block of threads for each. Parcel i has plane i and
// bricks 8 i and following, so that no thread waits for another's share.
#pragma once

#include "mapper/cuda/kernels/block_table.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kBrickWords = 3 * kBrickSize / 4;

/// Word w of a brick's packed RGB.
inline G3D_GPU std::uint32_t packed_word(const std::uint32_t* colours, int w) {
  std::uint32_t word = 0;
  for (int k = 0; k < 4; ++k) {
    const int byte = 4 * w + k;
    word |= (colours[byte / 3] >> (8 * (byte % 3)) & 0xFFU) << (8 * k);
  }
  return word;
}

/// Sends block `slot` as parcel `index`.
inline G3D_GPU void send_block(const Block& block, const Memory& m, const Parcels& out, std::uint32_t slot,
                               std::uint32_t index) {
  const GpuBlock& from = m.blocks[slot];
  block.each([&](int t) {
    std::uint32_t present = 0;
    for (int b = 0; b < kBricks; ++b) present |= from.bricks[b] != kNone ? 1U << b : 0U;
    if (t == 0) {
      ParcelHead head{};
      head.key = from.key;
      head.plane = from.plane == kNone ? kNone : index;
      head.uniform_level = static_cast<std::uint8_t>(from.uniform_level);
      head.bricks = static_cast<std::uint8_t>(present);
      head.first_brick = index * kBricks;
      out.heads[index] = head;
    }
    if (from.plane != kNone) {
      reinterpret_cast<AnyWord*>(out.planes[index].levels)[t] =
          reinterpret_cast<const AnyWord*>(m.planes + static_cast<std::size_t>(from.plane) * kVoxels)[t];
    }
    std::uint32_t rank = 0;
    for (int b = 0; b < kBricks; ++b) {
      if (from.bricks[b] == kNone) continue;
      const std::uint32_t* colours = m.colours + static_cast<std::size_t>(from.bricks[b]) * kBrickSize;
      AnyWord* words = reinterpret_cast<AnyWord*>(out.bricks[index * kBricks + rank++].rgb);
      if (t < kBrickWords) words[t] = packed_word(colours, t);
    }
  });
}

/// What the frame counted, to where the host reads it.
inline G3D_GPU void send_counters(const Block& block, const Memory& m, const FrameParams& f, FrameCounters* to) {
  PerThread<std::uint32_t, kParcelThreads> sums[3];
  PerThread<std::uint32_t, kParcelThreads> next[3];
  const int count = tiles(f.width_px, 32) * tiles(f.height_px, 32);
  block.lanes([&](int t) {
    for (auto& sum : sums) sum[t] = 0;
    if (t >= 32) return;
    for (int tile = t; tile < count; tile += 32) {
      for (int k = 0; k < 3; ++k) sums[k][t] += m.tile_kinds[4 * tile + k];
    }
  });
#pragma GCC unroll 1
  for (int bits = 1; bits < 32; bits *= 2) {
    block.lanes([&](int t) {
      for (int k = 0; k < 3; ++k) next[k][t] = sums[k][t] + sums[k].peer(t, bits);
    });
    block.lanes([&](int t) {
      for (int k = 0; k < 3; ++k) sums[k][t] = next[k][t];
    });
  }
  block.each([&](int t) {
    if (t != 0) return;
    FrameCounters counters = m.input->counters;
    counters.valid = sums[0][t];
    counters.too_near = sums[1][t];
    counters.far = sums[2][t];
    counters.refused_imports = m.state->refused_imports;
    *to = counters;
  });
}

struct ImportState {
  std::uint32_t plane;
  std::uint32_t bricks[kBricks];
  std::uint32_t accepted;
};

/// Takes parcel `index`: the block becomes what the host says, or is forgotten.
inline G3D_GPU void receive_block(const Block& block, const Memory& m, const Parcels& in, std::uint32_t index) {
  G3D_GPU_SHARED ImportState s;
  const ParcelHead& head = in.heads[index];
  block.each([&](int t) {
    if (t != 0) return;
    s.accepted = 0;
    if (head.erase != 0) {
      forget_block(m, head.key);
      return;
    }
    std::uint32_t slot = find_block(m, head.key);
    if (slot == kNone) slot = insert_block(m, head.key, index);
    MapState& map = *m.state;
    bool complete = slot != kNone;
    if (complete) {
      GpuBlock& to = m.blocks[slot];
      if (head.plane == kNone && to.plane != kNone) {
        give_back(map.planes, m.returned_planes, to.plane);
        to.plane = kNone;
      } else if (head.plane != kNone && to.plane == kNone) {
        to.plane = take(map.planes, m.free_planes, index);
        complete = to.plane != kNone;
      }
      to.uniform_level = head.uniform_level;
      s.plane = to.plane;
      for (int b = 0; b < kBricks; ++b) {
        const bool wanted = (head.bricks >> b & 1) != 0;
        if (wanted && to.bricks[b] == kNone) {
          to.bricks[b] = take(map.bricks, m.free_bricks, index);
          complete &= to.bricks[b] != kNone;
        } else if (!wanted && to.bricks[b] != kNone) {
          give_back(map.bricks, m.returned_bricks, to.bricks[b]);
          to.bricks[b] = kNone;
        }
        s.bricks[b] = to.bricks[b];
      }
    }
    s.accepted = complete ? 1 : 0;
    // The host's pools are no larger than the card's, so this is a fault to be reported, not a full map.
    if (!complete) atomic_add(&map.refused_imports, 1U);
  });
  block.each([&](int t) {
    // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): thread 0 is in every block and has set it
    if (s.accepted == 0) return;
    if (s.plane != kNone) {
      reinterpret_cast<AnyWord*>(m.planes + static_cast<std::size_t>(s.plane) * kVoxels)[t] =
          reinterpret_cast<const AnyWord*>(in.planes[head.plane].levels)[t];
    }
    std::uint32_t rank = 0;
    for (int b = 0; b < kBricks; ++b) {
      if ((head.bricks >> b & 1) == 0) continue;
      const std::uint8_t* rgb = in.bricks[head.first_brick + rank++].rgb;
      if (t < kBrickSize) {
        m.colours[static_cast<std::size_t>(s.bricks[b]) * kBrickSize + static_cast<std::uint32_t>(t)] =
            static_cast<std::uint32_t>(rgb[3 * t]) | static_cast<std::uint32_t>(rgb[3 * t + 1]) << 8 |
            static_cast<std::uint32_t>(rgb[3 * t + 2]) << 16;
      }
    }
  });
}

}  // namespace g3d::mapper::cuda
