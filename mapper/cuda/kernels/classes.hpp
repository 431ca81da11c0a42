// SPDX-License-Identifier: Apache-2.0
// Classes of changed blocks, 128 bytes instead of a whole block, for whoever waits for the frame: a warp for each
// block, sixteen voxels to a lane.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

[[nodiscard]] constexpr std::uint32_t class_of(std::uint32_t byte) {
  const std::uint32_t level = byte & kLevelMask;
  return level < kUnknownLevel ? 1U : level > kUnknownLevel ? 2U : 0U;
}

inline G3D_GPU void send_classes(const Team<1>& warp, const Memory& m, const Classes& out, std::uint32_t index) {
  const GpuBlock& from = m.blocks[m.changed[index]];
  warp.lanes([&](int t) {
    if (t == 0) {
      out.heads[index] = {from.key, from.plane == kNone ? class_of(from.uniform_level) : kNone, 0};
    }
    if (from.plane == kNone) return;
    const AnyQuad bytes =
        reinterpret_cast<const AnyQuad*>(m.planes + static_cast<std::size_t>(from.plane) * kVoxels)[t];
    std::uint32_t word = 0;
#pragma GCC unroll 16
    for (int i = 0; i < 16; ++i) word |= class_of(bytes.words[i / 4] >> (8 * (i % 4)) & 0xFFU) << (2 * i);
    out.planes[index].words[t] = word;
  });
}

}  // namespace g3d::mapper::cuda
