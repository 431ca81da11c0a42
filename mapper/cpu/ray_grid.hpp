// SPDX-License-Identifier: Apache-2.0
// Free space by walking every pixel's ray: exact (`dda`, Amanatides & Woo) or as the thesis does (`bresenham`). Rays
// mark a byte grid as large as the frame's box; blocks are then read out of it and wiped. Where many rays share each
// voxel, ExactRays finds what the exact walk marks faster.
#pragma once

#include "mapper/cpu/free_space.hpp"
#include "mapper/cpu/visible_blocks.hpp"
#include "mapper/mapper.hpp"
#include "mapper/pool.hpp"

namespace g3d::mapper::cpu {

class RayGrid final : public FreeSpace {
 public:
  /// `kind`: dda or bresenham.
  RayGrid(const SensorGeometry& sensor, IntegratorKind kind);
  void offer(const FrameWork& work) override;

 private:
  void walk(const FrameWork& work, bool strong);
  /// Moves one block's bytes from the grid to `flags`; false if none was marked.
  [[nodiscard]] bool read_out(const FrameGeometry& frame, const BlockView& block, FreeFlags& flags);

  IntegratorKind kind_;
  ReservedArray<std::uint8_t> grid_;  ///< x fastest; all zero between frames
  std::vector<float> column_slope_;   ///< padded to whole vectors
};

}  // namespace g3d::mapper::cpu
