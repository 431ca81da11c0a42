// SPDX-License-Identifier: Apache-2.0
// One depth image as oriented points: what an alignment matches and what a surface model is made of.
//
// The image is cut into tiles of about 1/160 of its width. A tile's depth is the mean of its readings in 1/z
// (disparity), in which planes are linear and a Kinect's noise is even, so that the mean of a tile lies on the plane
// that it shows; its normal comes from the tiles two steps away. Tiles at edges and creases are left out. float32 with
// + - * / and sqrt alone, in a fixed order: every machine makes the same samples. Nothing is allocated after
// construction. Thread: one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/align/depth_sample.hpp"

namespace g3d::mapper::align {

struct SampleOptions {
  float near_m = 0.6F;
  float far_m = 6.0F;
  float spacing_m = 0.06F;  ///< chosen samples lie about so far apart
  std::size_t most_chosen = 4096;
};

class DepthSamples {
 public:
  explicit DepthSamples(const hal::CameraModel& camera, const SampleOptions& options = {});

  void compute(const std::uint16_t* depth);

  /// Every tile that has a normal, row by row.
  [[nodiscard]] std::span<const DepthSample> all() const { return {samples_.data(), sample_count_}; }
  /// A part of them, even in space: a near wall does not outvote a far one.
  [[nodiscard]] std::span<const DepthSample> chosen() const { return {chosen_.data(), chosen_count_}; }

  [[nodiscard]] const SampleShape& shape() const { return shape_; }

 private:
  void average_tiles(const std::uint16_t* depth);
  void find_normals();
  void choose();

  SampleShape shape_;
  std::vector<float> inverse_of_raw_;  ///< 1/m of every raw reading, 0 outside of near..far
  std::vector<float> inverse_depth_;   ///< per tile, 1/m, 0 = none
  std::vector<float> column_slope_;    ///< x / z of a tile's centre
  std::vector<float> row_slope_;       ///< y / z
  std::vector<DepthSample> samples_;
  std::vector<DepthSample> chosen_;
  std::size_t sample_count_ = 0;
  std::size_t chosen_count_ = 0;
  std::vector<std::uint64_t> taken_;  ///< hash set of places that have a chosen sample
};

}  // namespace g3d::mapper::align
