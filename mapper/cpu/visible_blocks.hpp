// SPDX-License-Identifier: Apache-2.0
// Which blocks of the frame's box the rays can reach: the frustum, cut off at the first surface. Boxes of 4x4x4 blocks
// are tested first, so that most of what is hidden or outside costs one test for 64 blocks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "mapper/cpu/depth_pyramid.hpp"
#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/kernels/kernels.hpp"

namespace g3d::mapper::cpu {

enum class BlockClass : std::uint8_t {
  hidden,          ///< no ray reaches any of its voxels
  look,            ///< each voxel has to be looked at
  look_at_border,  ///< likewise, and some of it may lie outside of the image
  all_free,        ///< rays pass through every voxel
};

/// A block of the frame's box with the camera-frame position of the centre of its first (lowest) voxel.
struct BlockView {
  int bx = 0;
  int by = 0;
  int bz = 0;
  float x_m = 0;
  float y_m = 0;
  float z_m = 0;
  // What is known of the rays that pass it, where its class is `look`
  float farthest_m = 3.4e38F;  ///< no ray that any of its voxels looks at ends beyond
  float nearest_m = -3.4e38F;  ///< no ray through a voxel's middle ends nearer
};

/// What rounding and the raster of pixels mean for exact rays.
struct ExactBounds {
  float sure_m = std::numeric_limits<float>::infinity();  ///< no voxel behind this depth passes for all free
  float slack_m = 0;  ///< by how much rounding may carry a ray beside or beyond its line: cubes are this much larger
};

class VisibleBlocks {
 public:
  /// `footprint_px_m`: a voxel at depth z is looked up in a window of about footprint_px_m / z pixels; 0 = none.
  /// `bias_m`: a voxel is free only if the ray reaches this far beyond its centre (projective); 0 for exact rays.
  VisibleBlocks(const SensorGeometry& sensor, const FrameGeometry& frame, const DepthPyramid& pyramid,
                const Kernels& kernels, float footprint_px_m, float bias_m, const ExactBounds& exact = {});

  [[nodiscard]] std::uint32_t chunk_count() const { return static_cast<std::uint32_t>(supers_[1] * supers_[2]); }
  /// No chunk visits more blocks.
  [[nodiscard]] std::uint32_t blocks_per_chunk() const { return static_cast<std::uint32_t>(supers_[0]) * 64U; }

  /// visit(BlockView, BlockClass) for every block of the chunk that is not hidden, in a fixed order. `wants(bx, by,
  /// bz)` is asked before a block is looked at more closely; what it declines is not visited. `soon(bx, by, bz)` comes
  /// some blocks earlier, so that memory can be on its way.
  template <typename Soon, typename Wants, typename Visit>
  void for_chunk(std::uint32_t chunk, Soon&& soon, Wants&& wants, Visit&& visit) const {
    const int sy = static_cast<int>(chunk) % supers_[1];
    const int sz = static_cast<int>(chunk) / supers_[1];
    BoxBounds boxes;
    for (int sx = 0; sx < supers_[0]; ++sx) {
      const BlockView first = view(4 * sx, 4 * sy, 4 * sz);
      boxes.x_m[0] = first.x_m + super_middle_m_[0];
      boxes.y_m[0] = first.y_m + super_middle_m_[1];
      boxes.z_m[0] = first.z_m + super_middle_m_[2];
      kernels_->bound_boxes(super_view_, 1, boxes);
      BlockView rays;
      const BlockClass super = decide(boxes, 0, super_view_, rays);
      if (super == BlockClass::hidden) continue;
      for (std::size_t i = 0; i < 64; ++i) {
        boxes.x_m[i] = first.x_m + block_middle_m_[0][i];
        boxes.y_m[i] = first.y_m + block_middle_m_[1][i];
        boxes.z_m[i] = first.z_m + block_middle_m_[2][i];
      }
      if (super != BlockClass::all_free) kernels_->bound_boxes(block_view_, 64, boxes);
      std::array<std::uint8_t, 64> candidates;
      std::size_t count = 0;
      for (int i = 0; i < 64; ++i) {
        const int bx = 4 * sx + (i & 3);
        const int by = 4 * sy + ((i >> 2) & 3);
        const int bz = 4 * sz + (i >> 4);
        if (bx >= frame_->nx_blocks || by >= frame_->ny_blocks || bz >= frame_->nz_blocks) continue;
        if (super != BlockClass::all_free && boxes.hidden[i] != 0) continue;
        soon(bx, by, bz);
        candidates[count++] = static_cast<std::uint8_t>(i);
      }
      for (std::size_t c = 0; c < count; ++c) {
        const int i = candidates[c];
        const int bx = 4 * sx + (i & 3);
        const int by = 4 * sy + ((i >> 2) & 3);
        const int bz = 4 * sz + (i >> 4);
        if (!wants(bx, by, bz)) continue;
        BlockView block = view(bx, by, bz);
        const BlockClass found = super == BlockClass::all_free ? super : decide(boxes, i, block_view_, block);
        if (found != BlockClass::hidden) visit(block, found);
      }
    }
  }

  /// Classes of the eight bricks of 4x4x4 voxels of a block, in order of place.
  [[nodiscard]] std::array<BlockClass, 8> classify_bricks(const BlockView& block) const;
  /// Where a block's first voxel lies.
  [[nodiscard]] BlockView view(int bx, int by, int bz) const;

  /// The numbers behind all this, for a twin. Offsets axis by axis, from the centre of the first voxel.
  struct Numbers {
    const BoxView& super_view;
    const BoxView& block_view;
    const BoxView& brick_view;
    const std::array<float, 3>& super_middle_m;
    const std::array<std::array<float, 64>, 3>& block_middle_m;
    const std::array<std::array<float, 8>, 3>& brick_middle_m;
    const std::array<int, 3>& supers;
  };
  [[nodiscard]] Numbers numbers() const {
    return {super_view_, block_view_, brick_view_, super_middle_m_, block_middle_m_, brick_middle_m_, supers_};
  }

 private:
  [[nodiscard]] BoxView box_view(int side_cells) const;
  /// Every window contains its voxel's own pixel: if the rays of all these reach beyond a cube by this, all its voxels
  /// are free.
  [[nodiscard]] float behind_m(float z_m, float half_z_m) const {
    return z_m + half_z_m + std::max(bias_m_, 0.0F) + sensor_->metres_per_unit;
  }
  /// `rays`: gets farthest_m and nearest_m.
  [[nodiscard]] BlockClass decide(const BoxBounds& boxes, int i, const BoxView& view, BlockView& rays) const;

  const SensorGeometry* sensor_;
  const FrameGeometry* frame_;
  const DepthPyramid* pyramid_;
  const Kernels* kernels_;
  float footprint_px_m_;
  float bias_m_;
  ExactBounds exact_;
  std::array<int, 3> supers_;
  BoxView super_view_;
  BoxView block_view_;
  BoxView brick_view_;
  // Camera-frame offsets from the centre of the first voxel, axis by axis
  std::array<float, 3> super_middle_m_;
  std::array<std::array<float, 64>, 3> block_middle_m_;  ///< of the 64 blocks of a group, x fastest
  std::array<std::array<float, 8>, 3> brick_middle_m_;   ///< of the eight bricks of a block
};

/// Camera-frame position of a voxel's centre. float32, the same in every twin.
[[nodiscard]] std::array<float, 3> voxel_in_camera_m(const SensorGeometry& sensor, const FrameGeometry& frame,
                                                     const VoxelIndex& voxel);

}  // namespace g3d::mapper::cpu
