// SPDX-License-Identifier: Apache-2.0
// Small things that all kernels share. Kernel sources are seen by two compilers: after target_ptx.hpp by the one for
// the card, after target_host.hpp by the one for the emulation; so they name neither. float32, + - * / alone, the same
// operations in the same order as the CPU twin's.
#pragma once

#include "mapper/cuda/memory.hpp"
#include "mapper/morton.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kPixelThreads = 256;   ///< per block, in kernels over images and boxes
inline constexpr int kUpdateThreads = 128;  ///< per block, in the kernel that updates blocks of the map
inline constexpr int kParcelThreads = 128;  ///< per block, in kernels that move them: four voxels each

/// Memory of any type in larger pieces than it was declared.
using AnyWord [[gnu::may_alias]] = std::uint32_t;
using AnyHalf [[gnu::may_alias]] = std::uint16_t;
struct [[gnu::may_alias]] alignas(8) AnyPair {
  std::uint32_t low, high;
};
struct [[gnu::may_alias]] alignas(16) AnyQuad {
  std::uint32_t words[4];
};

template <typename T>
[[nodiscard]] constexpr T least(T a, T b) {
  return b < a ? b : a;
}
template <typename T>
[[nodiscard]] constexpr T most(T a, T b) {
  return a < b ? b : a;
}
[[nodiscard]] constexpr bool walks_rays(FreeBy by) { return by == FreeBy::exact_rays || by == FreeBy::thesis_rays; }
[[nodiscard]] constexpr int tiles(int size, int tile) { return (size + tile - 1) / tile; }

/// 2^15 - 1 + ceil(x), relative to an origin.
inline G3D_GPU std::int32_t cell_of(float x_cells, std::int32_t origin) {
  return static_cast<std::int32_t>(__builtin_ceilf(x_cells)) + 32767 - origin;
}

inline G3D_GPU std::uint32_t block_id_at(const FrameParams& f, int bx, int by, int bz) {
  return static_cast<std::uint32_t>(bx + f.blocks[0] * (by + f.blocks[1] * bz));
}

inline G3D_GPU std::uint64_t block_key_at(const FrameParams& f, int bx, int by, int bz) {
  return block_of({f.origin[0] + 8 * bx, f.origin[1] + 8 * by, f.origin[2] + 8 * bz});
}

/// How many places the warps of a block want in up to two lists, and where theirs begin.
struct ListShares {
  std::uint32_t wanted[2][kPixelThreads / 32];
  std::uint32_t first[2][kPixelThreads / 32];
};

/// Places in lists for the threads that want one, side by side: one atomic operation for a block of threads and a list.
template <int kLists>
inline G3D_GPU void append(const Block& block, ListShares& s, PerThread<std::uint32_t, kPixelThreads> (&wants)[kLists],
                           std::uint32_t* const (&counters)[kLists],
                           PerThread<std::uint32_t, kPixelThreads> (&places)[kLists]) {
  block.each([&](int t) {
#pragma GCC unroll 2
    for (int list = 0; list < kLists; ++list) {
      const std::uint32_t lanes = wants[list].ballot(t);
      places[list][t] = static_cast<std::uint32_t>(__builtin_popcount(lanes & ((1U << (t % 32)) - 1)));
      if (t % 32 == 0) s.wanted[list][t / 32] = static_cast<std::uint32_t>(__builtin_popcount(lanes));
    }
  });
  block.each([&](int t) {
    if (t % 32 != 0 || t / 32 >= kLists) return;
    std::uint32_t sum = 0;
    for (std::uint32_t wanted : s.wanted[t / 32]) sum += wanted;
    std::uint32_t first = sum != 0 ? atomic_add(t == 0 ? counters[0] : counters[kLists - 1], sum) : 0;
    for (int warp = 0; warp < kPixelThreads / 32; ++warp) {
      s.first[t / 32][warp] = first;
      first += s.wanted[t / 32][warp];
    }
  });
  block.lanes([&](int t) {
#pragma GCC unroll 2
    for (int list = 0; list < kLists; ++list) places[list][t] += s.first[list][t / 32];
  });
}

/// Camera-frame position of the centre of a block's first voxel; see cpu::voxel_in_camera_m.
struct Corner {
  float x_m;
  float y_m;
  float z_m;
};
inline G3D_GPU Corner corner_of(const FrameParams& f, int bx, int by, int bz) {
  const float* R = f.rotation;
  const float x = (static_cast<float>(f.origin[0] + 8 * bx) - 32767.5F) * f.resolution_m - f.translation_m[0];
  const float y = (static_cast<float>(f.origin[1] + 8 * by) - 32767.5F) * f.resolution_m - f.translation_m[1];
  const float z = (static_cast<float>(f.origin[2] + 8 * bz) - 32767.5F) * f.resolution_m - f.translation_m[2];
  return {R[0] * x + R[3] * y + R[6] * z, R[1] * x + R[4] * y + R[7] * z, R[2] * x + R[5] * y + R[8] * z};
}

}  // namespace g3d::mapper::cuda
