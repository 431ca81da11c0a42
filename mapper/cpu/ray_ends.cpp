// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/ray_ends.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace g3d::mapper::cpu {
namespace {

constexpr int kRowsPerChunk = 32;
constexpr int kColumnsPerChunk = 160;
// Eight pixels are looked at together; behind each row, so that the last look stays out of another thread's rows.
constexpr int kBlindPadding = 8;

std::uint32_t chunks_of(int count, int size) { return static_cast<std::uint32_t>((count + size - 1) / size); }

}  // namespace

RayEnds::RayEnds(const SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask, std::uint16_t mask_raw,
                 bool carve_invalid)
    : sensor_(&sensor),
      width_(sensor.camera.width_px),
      height_(sensor.camera.height_px),
      stride_((width_ + 2 * kImagePadding + 31) / 32 * 32),
      carve_invalid_(carve_invalid),
      mask_is_one_row_(scan_mask.empty()),
      mask_(mask_is_one_row_ ? static_cast<std::size_t>(width_) : sensor.camera.pixel_count(),
            std::min(mask_raw, sensor.far_raw)),
      least_end_(sensor.near_raw),
      ends_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height_ + 2 * kImagePadding) + 64U, 0),
      colour_flags_(sensor.camera.pixel_count()),
      blind_(static_cast<std::size_t>((width_ + kBlindPadding) * height_), 0),
      row_counts_(static_cast<std::size_t>(height_)) {
  for (std::size_t i = 0; i < std::min(scan_mask.size(), mask_.size()); ++i) {
    mask_[i] = std::min(scan_mask[i], sensor.far_raw);
  }
  for (const std::uint16_t raw : mask_) {
    if (raw != 0) least_end_ = std::min(least_end_, raw);
  }
}

void RayEnds::compute(const std::uint16_t* depth, const Kernels& kernels, ThreadPool& pool) {
  depth_ = depth;
  pool.parallel_for(chunks_of(height_, kRowsPerChunk), [&](std::uint32_t chunk) {
    const int first = static_cast<int>(chunk) * kRowsPerChunk;
    const int end = std::min(height_, first + kRowsPerChunk);
    classify_rows(first, end, kernels);
    if (carve_invalid_) bound_by_rows(first, end);
  });
  counts_ = {};
  for (const RowCounts& row : row_counts_) {
    counts_.valid += row.valid;
    counts_.too_near += row.too_near;
    counts_.far += row.far;
    counts_.invalid += row.invalid;
  }
  if (!carve_invalid_ || counts_.invalid == 0) return;
  pool.parallel_for(chunks_of(width_, kColumnsPerChunk), [&](std::uint32_t chunk) {
    const int first = static_cast<int>(chunk) * kColumnsPerChunk;
    bound_by_columns(first, std::min(width_, first + kColumnsPerChunk), kernels);
  });
}

void RayEnds::classify_rows(int first, int end, const Kernels& kernels) {
  for (int v = first; v < end; ++v) {
    const std::uint16_t* row = depth_ + v * width_;
    row_counts_[static_cast<std::size_t>(v)] =
        kernels.classify_row({row, v > 0 ? row - width_ : row, v + 1 < height_ ? row + width_ : row, width_,
                              sensor_->near_raw, sensor_->far_raw, ends_.data() + index(0, v),
                              colour_flags_.data() + v * width_, blind_.data() + v * (width_ + kBlindPadding)});
  }
}

void RayEnds::bound_by_rows(int first, int end) {
  for (int v = first; v < end; ++v) {
    if (row_counts_[static_cast<std::size_t>(v)].invalid == 0) continue;
    const std::uint16_t* row = depth_ + v * width_;
    std::uint16_t* ends = ends_.data() + index(0, v);
    const std::uint8_t* blind = blind_.data() + v * (width_ + kBlindPadding);
    for (int u = next_blind(blind, 0); u < width_;) {
      int run_end = u + 1;
      while (run_end < width_ && row[run_end] == 0) ++run_end;
      std::uint16_t nearest = u > 0 ? row[u - 1] : kUnbounded;
      if (run_end < width_) nearest = std::min(nearest, row[run_end]);
      std::fill(ends + u, ends + run_end, nearest);
      u = next_blind(blind, run_end);
    }
  }
}

// First blind pixel from `u` on, eight at a time; the row's width if there is none.
int RayEnds::next_blind(const std::uint8_t* blind, int u) const {
  while (u < width_) {
    std::uint64_t eight;
    std::memcpy(&eight, blind + u, sizeof eight);
    if (eight != 0) return std::min(width_, u + std::countr_zero(eight) / 8);
    u += 8;
  }
  return width_;
}

void RayEnds::bound_by_columns(int first, int end, const Kernels& kernels) {
  const int count = end - first;
  alignas(64) std::uint16_t last[kColumnsPerChunk];
  // Downwards: the reading above each run. Rows are walked whole, so that memory is read in order. Until the upward
  // pass is through, the ends of pixels without a reading hold the nearest bound found so far.
  std::fill(last, last + count, kUnbounded);
  for (int v = 0; v < height_; ++v) {
    kernels.carry_down(depth_ + v * width_ + first, count, last, ends_.data() + index(first, v));
  }
  // Upwards: the reading below, and all four together.
  std::fill(last, last + count, kUnbounded);
  for (int v = height_ - 1; v >= 0; --v) {
    const std::uint16_t* mask = mask_.data() + (mask_is_one_row_ ? 0 : v * width_) + first;
    kernels.bound_up(
        {depth_ + v * width_ + first, mask, count, sensor_->near_raw, last, ends_.data() + index(first, v)});
  }
}

}  // namespace g3d::mapper::cpu
