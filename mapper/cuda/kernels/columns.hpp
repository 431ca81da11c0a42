// SPDX-License-Identifier: Apache-2.0
// What changed blocks say about the floor cells below them: a warp for each block, two columns of voxels to a lane.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

using ColumnShare = std::uint8_t[kBlockSide_cells * kBlockSide_cells];

inline G3D_GPU void read_block_columns(const Team<1>& warp, const Memory& m, ColumnShare& share, std::uint32_t slot,
                                       std::uint32_t index) {
  const ColumnTables& tables = *m.column_tables;
  const GpuBlock& from = m.blocks[slot];
  const std::int32_t layer = column_layer(tables, from.key);
  warp.each([&](int t) {
    if (t == 0) m.column_keys[index] = layer < 0 ? kForgotten : from.key;
    if (layer < 0) return;
    const std::uint8_t* plane = m.planes + static_cast<std::size_t>(from.plane == kNone ? 0 : from.plane) * kVoxels;
    for (int column = t; column < kBlockSide_cells * kBlockSide_cells; column += 32) {
      std::uint8_t bits = 0;
#pragma GCC unroll 8
      for (int z = 0; z < kBlockSide_cells; ++z) {
        const std::uint32_t byte =
            from.plane == kNone ? from.uniform_level : plane[place_at(column & 7, column >> 3, z)];
        bits = joined_bits(bits, tables.bits[tables.kinds[layer][z]][byte & kLevelMask]);
      }
      share[column] = bits;
    }
  });
  warp.each([&](int t) {
    if (layer < 0) return;
    const int voxels = tables.voxels_per_cell;
    const int side = kBlockSide_cells / voxels;
    for (int cell = t; cell < side * side; cell += 32) {
      const int first = cell / side * voxels * kBlockSide_cells + cell % side * voxels;
      std::uint8_t bits = 0;
      for (int i = 0; i < voxels * voxels; ++i) {
        bits = joined_bits(bits, share[first + i / voxels * kBlockSide_cells + i % voxels]);
      }
      m.column_cells[index * static_cast<std::uint32_t>(side * side) + static_cast<std::uint32_t>(cell)] = bits;
    }
  });
}

/// Changed blocks from number `first` on, as many as there is room for.
inline G3D_GPU void read_columns(const Block& block, const Memory& m, std::uint32_t first, std::uint32_t room) {
  G3D_GPU_SHARED ColumnShare shares[kParcelThreads / 32];
  const std::uint32_t end = least(m.input->counters.changed, first + room);
  block.teams<1>([&](const Team<1>& warp) {
    for (std::uint32_t i = first + static_cast<std::uint32_t>(warp.index); i < end;
         i += static_cast<std::uint32_t>(warp.count)) {
      read_block_columns(warp, m, shares[warp.in_block], m.changed[i], i - first);
    }
  });
}

}  // namespace g3d::mapper::cuda
