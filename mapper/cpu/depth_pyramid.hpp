// SPDX-License-Identifier: Apache-2.0
// Minimum and maximum of the ray ends over squares of 2^L pixels: what a whole block may conclude from a few cells.
#pragma once

#include <cstdint>
#include <vector>

#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/ray_ends.hpp"
#include "mapper/cpu/thread_pool.hpp"

namespace g3d::mapper::cpu {

class DepthPyramid {
 public:
  DepthPyramid(int width_px, int height_px);

  void compute(const RayEnds& ends, const Kernels& kernels, ThreadPool& pool);

  struct Range {
    std::uint16_t min;
    std::uint16_t max;
  };
  /// Bounds of all ends in columns u0..u1 and rows v0..v1 (inside the image, ends included): possibly a little wider.
  [[nodiscard]] Range range(int u0, int v0, int u1, int v1) const;

  [[nodiscard]] int level_count() const { return static_cast<int>(levels_.size()); }

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<Range> cells;

    [[nodiscard]] const Range* row(int y) const {
      return cells.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
    [[nodiscard]] Range* row(int y) {
      return cells.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
  };
  std::vector<Level> levels_;  ///< levels_[0] has cells of 4 x 4 pixels
};

}  // namespace g3d::mapper::cpu
