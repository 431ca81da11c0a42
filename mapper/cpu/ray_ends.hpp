// SPDX-License-Identifier: Apache-2.0
// For every pixel the raw depth up to which its ray shows free space, and whether the pixel may give its colour.
//
//   reading within the certainty bounds   carves to the reading
//   beyond far_m                          carves to far_m
//   nearer than near_m                    carves nothing (and is counted: navigation is told); no other ray of the
//                                         frame frees the voxel in which it lies (see HitScatter)
//   no reading                            the free scan mask, but never beyond the nearest of the readings that bound
//                                         the invalid run along its row and its column; nothing if none bounds it or
//                                         if that nearest reading is itself too near (then the run may well be too
//                                         near, too)
// Ends of pixels without a reading are *weak*: they never wear down what was measured (see ApplyBlock).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/cpu/thread_pool.hpp"

namespace g3d::mapper::cpu {

/// The image of ray ends is padded with zeros, so that windows may reach over the border.
inline constexpr int kImagePadding = 8;

class RayEnds {
 public:
  /// `scan_mask`: width * height raw depths; empty = `mask_raw` everywhere.
  RayEnds(const SensorGeometry& sensor, std::span<const std::uint16_t> scan_mask, std::uint16_t mask_raw,
          bool carve_invalid);

  void compute(const std::uint16_t* depth, const Kernels& kernels, ThreadPool& pool);

  /// End of pixel (u, v), raw units, 0 = carves nothing.
  [[nodiscard]] std::uint16_t at(int u, int v) const { return ends_[index(u, v)]; }
  /// True if the end rests on a reading.
  [[nodiscard]] bool is_strong(int u, int v) const {
    return depth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)] != 0;
  }
  /// No ray ends nearer, whatever the image.
  [[nodiscard]] std::uint16_t least_end() const { return least_end_; }
  [[nodiscard]] const std::uint16_t* padded() const { return ends_.data(); }
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] const std::uint8_t* colour_flags() const { return colour_flags_.data(); }
  [[nodiscard]] const RowCounts& counts() const { return counts_; }
  [[nodiscard]] const std::uint16_t* depth() const { return depth_; }

 private:
  [[nodiscard]] std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v + kImagePadding) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(u + kImagePadding);
  }
  void classify_rows(int first, int end, const Kernels& kernels);
  void bound_by_rows(int first, int end);
  [[nodiscard]] int next_blind(const std::uint8_t* blind, int u) const;
  void bound_by_columns(int first, int end, const Kernels& kernels);

  const SensorGeometry* sensor_;
  const std::uint16_t* depth_ = nullptr;
  int width_;
  int height_;
  int stride_;
  bool carve_invalid_;
  bool mask_is_one_row_;  ///< the mask made from the intrinsics is the same everywhere
  std::vector<std::uint16_t> mask_;
  std::uint16_t least_end_;
  std::vector<std::uint16_t> ends_;
  std::vector<std::uint8_t> colour_flags_;
  std::vector<std::uint8_t> blind_;  ///< 1 where there is no reading; rows are padded
  std::vector<RowCounts> row_counts_;
  RowCounts counts_;
};

}  // namespace g3d::mapper::cpu
