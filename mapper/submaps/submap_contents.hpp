// SPDX-License-Identifier: Apache-2.0
// What a submap holds, and the same as bytes:
//
//   u32 surfaces, u32 bytes of each; those bytes; then twice, for its voxels and for its sketch of space, the map
//   map      f32 resolution (0: there is none), u32 blocks, groups
//   group    u32 bytes, payload (block_codec.hpp)
//
// Bit-identical both ways. Thread: one. Allocates.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/result.hpp"
#include "mapper/align/depth_sample.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::submaps {

struct SubmapContents {
  std::unique_ptr<VoxelMap> voxels;          ///< stored codes
  std::vector<align::DepthSample> surfaces;  ///< all that its frames have shown, in the frame of its voxels
  std::unique_ptr<VoxelMap> space;           ///< the same, coarse, may be nullptr

  [[nodiscard]] std::uint64_t memory_bytes() const;
};

/// A map with room for so many blocks and no more.
[[nodiscard]] std::unique_ptr<VoxelMap> map_for_blocks(const Grid& grid, std::size_t blocks);

[[nodiscard]] Bytes to_bytes(const SubmapContents& contents);
/// Errors: truncated, malformed, too_large, out_of_range; texts say what is wrong, not where.
[[nodiscard]] hal::Result<SubmapContents> from_bytes(ByteSpan bytes);

}  // namespace g3d::mapper::submaps
