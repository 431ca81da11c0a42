// SPDX-License-Identifier: Apache-2.0
// Which blocks of the frame's box the rays can reach: the frustum, cut off at the first surface. Boxes of 4x4x4 blocks
// are tested first, so that most of what is hidden or outside costs one test for 64 blocks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "mapper/cpu/depth_pyramid.hpp"
#include "mapper/cpu/frame_geometry.hpp"

namespace g3d::mapper::cpu {

enum class BlockClass : std::uint8_t {
  hidden,    ///< no ray reaches any of its voxels
  look,      ///< each voxel has to be looked at
  look_at_border,  ///< likewise, and some of it may lie outside of the image
  all_free,  ///< rays pass through every voxel
};

/// A block of the frame's box with the camera-frame position of the centre of its first (lowest) voxel.
struct BlockView {
  int bx = 0;
  int by = 0;
  int bz = 0;
  float x_m = 0;
  float y_m = 0;
  float z_m = 0;
};

class VisibleBlocks {
 public:
  /// `footprint_px_m`: a voxel at depth z is looked up in a window of about footprint_px_m / z pixels; 0 = none.
  /// `bias_m`: a voxel is free only if the ray reaches this far beyond its centre (projective); 0 for exact rays.
  VisibleBlocks(const SensorGeometry& sensor, const FrameGeometry& frame, const DepthPyramid& pyramid,
                float footprint_px_m, float bias_m);

  [[nodiscard]] std::uint32_t chunk_count() const { return static_cast<std::uint32_t>(supers_[1] * supers_[2]); }
  /// No chunk visits more blocks.
  [[nodiscard]] std::uint32_t blocks_per_chunk() const { return static_cast<std::uint32_t>(supers_[0]) * 64U; }

  /// visit(BlockView, BlockClass) for every block of the chunk that is not hidden, in a fixed order. `wants(bx, by, bz)`
  /// is asked before a block is looked at more closely; what it declines is not visited.
  template <typename Wants, typename Visit>
  void for_chunk(std::uint32_t chunk, Wants&& wants, Visit&& visit) const {
    const int sy = static_cast<int>(chunk) % supers_[1];
    const int sz = static_cast<int>(chunk) / supers_[1];
    for (int sx = 0; sx < supers_[0]; ++sx) {
      const BlockClass super = classify(view(4 * sx, 4 * sy, 4 * sz), 4 * kBlockSide_cells);
      if (super == BlockClass::hidden) continue;
      for (int bz = 4 * sz; bz < std::min(4 * sz + 4, frame_->nz_blocks); ++bz) {
        for (int by = 4 * sy; by < std::min(4 * sy + 4, frame_->ny_blocks); ++by) {
          for (int bx = 4 * sx; bx < std::min(4 * sx + 4, frame_->nx_blocks); ++bx) {
            if (!wants(bx, by, bz)) continue;
            const BlockView block = view(bx, by, bz);
            const BlockClass found = super == BlockClass::all_free ? super : classify(block, kBlockSide_cells);
            if (found != BlockClass::hidden) visit(block, found);
          }
        }
      }
    }
  }

  [[nodiscard]] BlockView view(int bx, int by, int bz) const;
  /// A cube of side_cells^3 voxels whose lowest voxel's centre is at `first`.
  [[nodiscard]] BlockClass classify(const BlockView& first, int side_cells) const;

 private:
  const SensorGeometry* sensor_;
  const FrameGeometry* frame_;
  const DepthPyramid* pyramid_;
  float footprint_px_m_;
  float bias_m_;
  std::array<float, 3> extent_per_voxel_m_;  ///< half extents of one voxel along the camera's axes
  std::array<float, 3> diagonal_m_;          ///< camera-frame offset of one voxel along all three grid axes at once
  std::array<int, 3> supers_;
};

/// Camera-frame position of a voxel's centre. float32, the same in every twin.
[[nodiscard]] std::array<float, 3> voxel_in_camera_m(const SensorGeometry& sensor, const FrameGeometry& frame,
                                                     const VoxelIndex& voxel);

}  // namespace g3d::mapper::cpu
