// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/footprint_images.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace g3d::mapper::cpu {
namespace {

constexpr int kImageRowsPerChunk = 64;
constexpr float kLargestWindow =
    static_cast<float>(kMaxWindow) + 0.5F;  // cells; larger ones are looked up a level higher
constexpr int kFirstWindowAbove = 4;  // windows of 1..3 cells of level L are those of 2..6 cells below it, but coarser

std::uint32_t chunks_of(int rows) {
  return static_cast<std::uint32_t>((rows + kImageRowsPerChunk - 1) / kImageRowsPerChunk);
}

}  // namespace

FootprintImages::FootprintImages(int width_px, int height_px, float smallest_window_px)
    : smallest_window_(std::clamp(static_cast<int>(std::lround(smallest_window_px)), 1, 1 << 12)) {
  int width = width_px;
  int height = height_px;
  for (int l = 0; l < kMaxLevels && (l == 0 || std::min(width, height) > 1); ++l) {
    FootprintLevel level;
    level.width = width;
    level.height = height;
    level.stride = (width + 2 * kImagePadding + 31) / 32 * 32;
    level.rows = height + 2 * kImagePadding;
    levels_.push_back(level);
    const std::size_t cells = static_cast<std::size_t>(level.stride) * static_cast<std::size_t>(level.rows) + 64U;
    std::vector<std::vector<std::uint16_t>> windows(kMaxWindow + 1);
    for (int m = l == 0 ? 2 : 1; m <= kMaxWindow; ++m) windows[static_cast<std::size_t>(m)].assign(cells, 0);
    images_.push_back(std::move(windows));
    width = (width + 1) / 2;
    height = (height + 1) / 2;
  }
}

FootprintImages::Choice FootprintImages::choose(float size_px) const {
  assert(size_px >= smallest_px_);
  int level = 0;
  float cells = size_px;
  while (cells > kLargestWindow && level + 1 < level_count()) {
    cells *= 0.5F;
    ++level;
  }
  const int least = level == 0 ? std::min(smallest_window_, kMaxWindow) : kFirstWindowAbove;
  // The nearest whole number, as half of an odd or even number of halves: floor() is a call on plain amd64.
  const int halves = static_cast<int>(2.0F * cells + 1.0F);
  return {level, std::clamp(halves / 2, least, kMaxWindow)};
}

// Windows begin at whole cells: one cell more than the size makes up for it.
std::optional<FootprintImages::Choice> FootprintImages::covering(float size_px) const {
  float cells = size_px;
  for (int level = 0; level < level_count(); ++level, cells *= 0.5F) {
    const int least = level == 0 ? smallest_window_ : kFirstWindowAbove;
    if (least > kMaxWindow || cells + 1.0F > static_cast<float>(kMaxWindow)) continue;
    return Choice{level, std::max(static_cast<int>(std::ceil(cells + 1.0F)), least)};
  }
  return std::nullopt;
}

void FootprintImages::compute(const RayEnds& ends, const Kernels& kernels, ThreadPool& pool, float smallest_px) {
  ends_ = ends.padded();
  smallest_px_ = smallest_px;
  for (int l = 0; l < level_count(); ++l) {
    if (l > 0) halve(l, kernels, pool);
    const int least = l == 0 ? smallest_window_ : kFirstWindowAbove;
    const bool is_last = l + 1 == level_count();
    if (least > kMaxWindow || (!is_last && smallest_px > kLargestWindow * static_cast<float>(1 << l))) continue;
    // Doubling up to the smallest window that is asked for, then one cell more each time.
    int have = 1;
    while (have < least) {
      const int next = std::min(2 * have, least);
      widen(l, have, next, kernels, pool);
      have = next;
    }
    for (; have < kMaxWindow; ++have) widen(l, have, have + 1, kernels, pool);
  }
}

void FootprintImages::widen(int l, int from, int to, const Kernels& kernels, ThreadPool& pool) {
  const FootprintLevel& level = levels_[static_cast<std::size_t>(l)];
  const std::uint16_t* source = image({l, from});
  std::uint16_t* target = images_[static_cast<std::size_t>(l)][static_cast<std::size_t>(to)].data();
  const int shift = to - from;
  const int rows = level.rows - shift;
  const int count = level.stride - shift;
  pool.parallel_for(chunks_of(rows), [&](std::uint32_t chunk) {
    const int first = static_cast<int>(chunk) * kImageRowsPerChunk;
    for (int y = first; y < std::min(rows, first + kImageRowsPerChunk); ++y) {
      kernels.max_filter_row(source + y * level.stride, source + (y + shift) * level.stride, shift, count,
                             target + y * level.stride);
    }
  });
}

void FootprintImages::halve(int l, const Kernels& kernels, ThreadPool& pool) {
  const FootprintLevel& below = levels_[static_cast<std::size_t>(l - 1)];
  const FootprintLevel& level = levels_[static_cast<std::size_t>(l)];
  const std::uint16_t* source = image({l - 1, 1});
  std::uint16_t* target = images_[static_cast<std::size_t>(l)][1].data();
  pool.parallel_for(chunks_of(level.height), [&](std::uint32_t chunk) {
    const int first = static_cast<int>(chunk) * kImageRowsPerChunk;
    for (int y = first; y < std::min(level.height, first + kImageRowsPerChunk); ++y) {
      // Below an odd last row lies padding: zeros, which a maximum ignores.
      const std::uint16_t* a = source + (2 * y + kImagePadding) * below.stride + kImagePadding;
      kernels.halve_max_row(a, a + below.stride, level.width,
                            target + (y + kImagePadding) * level.stride + kImagePadding);
    }
  });
}

}  // namespace g3d::mapper::cpu
