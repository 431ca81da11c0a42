// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/depth_pyramid.hpp"

#include <algorithm>
#include <array>

namespace g3d::mapper::cpu {
namespace {

constexpr int kBaseShift = 2;  // the first level kept has cells of 4 pixels: finer ones never pay
constexpr int kMostCells = 4;  // along each axis of one look-up

}  // namespace

DepthPyramid::DepthPyramid(int width_px, int height_px) {
  int cell = 1 << kBaseShift;
  for (;;) {
    Level level;
    level.width = (width_px + cell - 1) / cell;
    level.height = (height_px + cell - 1) / cell;
    level.cells.resize(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height));
    levels_.push_back(std::move(level));
    if (levels_.back().width <= kMostCells && levels_.back().height <= kMostCells) break;
    cell *= 2;
  }
}

void DepthPyramid::compute(const RayEnds& ends, const Kernels& kernels, ThreadPool& pool) {
  Level& base = levels_[0];
  const int stride = ends.stride();
  const std::uint16_t* image = ends.padded() + kImagePadding * stride + kImagePadding;
  pool.parallel_for(static_cast<std::uint32_t>((base.height + 7) / 8), [&](std::uint32_t chunk) {
    using HalfRow = std::array<std::uint16_t, hal::kMaxImageSide_px / 2 + 64>;
    alignas(64) HalfRow upper;
    alignas(64) HalfRow lower;
    alignas(64) HalfRow low;
    alignas(64) HalfRow high;
    const int first = static_cast<int>(chunk) * 8;
    for (int y = first; y < std::min(base.height, first + 8); ++y) {
      // Cells that stick out over the border see the padding's zeros: a lower minimum is always safe.
      const std::uint16_t* row = image + 4 * y * stride;
      const auto shrink = [&](auto halve, HalfRow& out) {
        halve(row, row + stride, 2 * base.width, upper.data());
        halve(row + 2 * stride, row + 3 * stride, 2 * base.width, lower.data());
        halve(upper.data(), lower.data(), base.width, out.data());
      };
      shrink(kernels.halve_min_row, low);
      shrink(kernels.halve_max_row, high);
      Range* cells = base.row(y);
      for (std::size_t x = 0; x < static_cast<std::size_t>(base.width); ++x) cells[x] = {low[x], high[x]};
    }
  });
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    const Level& below = levels_[l - 1];
    Level& level = levels_[l];
    for (int y = 0; y < level.height; ++y) {
      const Range* upper = below.row(2 * y);
      const Range* lower = below.row(std::min(2 * y + 1, below.height - 1));
      Range* out = level.row(y);
      for (int x = 0; x < level.width; ++x) {
        const int x0 = 2 * x;
        const int x1 = std::min(2 * x + 1, below.width - 1);
        const Range& a = upper[x0];
        const Range& b = upper[x1];
        const Range& c = lower[x0];
        const Range& d = lower[x1];
        out[x] = {std::min(std::min(a.min, b.min), std::min(c.min, d.min)),
                  std::max(std::max(a.max, b.max), std::max(c.max, d.max))};
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
    const Range* row = level.row(y);
    for (int x = u0 >> shift; x <= u1 >> shift; ++x) {
      range.min = std::min(range.min, row[x].min);
      range.max = std::max(range.max, row[x].max);
    }
  }
  return range;
}

}  // namespace g3d::mapper::cpu
