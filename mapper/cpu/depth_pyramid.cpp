// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/depth_pyramid.hpp"

#include <algorithm>

namespace g3d::mapper::cpu {
namespace {

constexpr int kBaseShift = 2;       // the first level kept has cells of 4 pixels: finer ones never pay
constexpr int kMostCells = 4;       // along each axis of one look-up

}  // namespace

DepthPyramid::DepthPyramid(int width_px, int height_px) {
  int cell = 1 << kBaseShift;
  for (;;) {
    Level level;
    level.width = (width_px + cell - 1) / cell;
    level.height = (height_px + cell - 1) / cell;
    const std::size_t cells = static_cast<std::size_t>(level.width * level.height) + 64U;
    level.min.resize(cells);
    level.max.resize(cells);
    levels_.push_back(std::move(level));
    if (levels_.back().width <= kMostCells && levels_.back().height <= kMostCells) break;
    cell *= 2;
  }
}

void DepthPyramid::compute(const RayEnds& ends, ThreadPool& pool) {
  Level& base = levels_[0];
  const int stride = ends.stride();
  const std::uint16_t* image = ends.padded() + kImagePadding * stride + kImagePadding;
  pool.parallel_for(static_cast<std::uint32_t>((base.height + 7) / 8), [&](std::uint32_t chunk) {
    const int first = static_cast<int>(chunk) * 8;
    for (int y = first; y < std::min(base.height, first + 8); ++y) {
      for (int x = 0; x < base.width; ++x) {
        std::uint16_t low = 0xFFFF;
        std::uint16_t high = 0;
        // Cells that stick out over the border see the padding's zeros: a lower minimum is always safe.
        for (int dy = 0; dy < 4; ++dy) {
          const std::uint16_t* row = image + (4 * y + dy) * stride + 4 * x;
          for (int dx = 0; dx < 4; ++dx) {
            low = std::min(low, row[dx]);
            high = std::max(high, row[dx]);
          }
        }
        base.min[static_cast<std::size_t>(y * base.width + x)] = low;
        base.max[static_cast<std::size_t>(y * base.width + x)] = high;
      }
    }
  });
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const Level& below = levels_[l - 1];
    Level& level = levels_[l];
    for (int y = 0; y < level.height; ++y) {
      const int y0 = 2 * y;
      const int y1 = std::min(2 * y + 1, below.height - 1);
      for (int x = 0; x < level.width; ++x) {
        const int x0 = 2 * x;
        const int x1 = std::min(2 * x + 1, below.width - 1);
        const auto a = static_cast<std::size_t>(y0 * below.width + x0);
        const auto b = static_cast<std::size_t>(y0 * below.width + x1);
        const auto c = static_cast<std::size_t>(y1 * below.width + x0);
        const auto d = static_cast<std::size_t>(y1 * below.width + x1);
        const auto i = static_cast<std::size_t>(y * level.width + x);
        level.min[i] = std::min(std::min(below.min[a], below.min[b]), std::min(below.min[c], below.min[d]));
        level.max[i] = std::max(std::max(below.max[a], below.max[b]), std::max(below.max[c], below.max[d]));
      }
    }
  }
}

DepthPyramid::Range DepthPyramid::range(int u0, int v0, int u1, int v1) const {
  const int extent = std::max(u1 - u0, v1 - v0);
  std::size_t l = 0;
  while ((extent >> (kBaseShift + static_cast<int>(l))) >= kMostCells - 1 && l + 1 < levels_.size()) ++l;
  const Level& level = levels_[l];
  const int shift = kBaseShift + static_cast<int>(l);
  Range range{0xFFFF, 0};
  for (int y = v0 >> shift; y <= v1 >> shift; ++y) {
    for (int x = u0 >> shift; x <= u1 >> shift; ++x) {
      const auto i = static_cast<std::size_t>(y * level.width + x);
      range.min = std::min(range.min, level.min[i]);
      range.max = std::max(range.max, level.max[i]);
    }
  }
  return range;
}

}  // namespace g3d::mapper::cpu
