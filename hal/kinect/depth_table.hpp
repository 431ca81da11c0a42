// SPDX-License-Identifier: Apache-2.0
// The depth correction of a calibration, for every reading that there can be: a reading is one look-up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/kinect/calibration.hpp"

namespace g3d::hal::kinect {

class DepthTable {
 public:
  /// Farther readings are none: a Kinect 360 says up to 10 m, and nothing sensible beyond.
  static constexpr std::uint16_t kFarthest_mm = 10'000;

  explicit DepthTable(const Calibration& calibration);
  /// 0 stays 0; what would not fit is 0.
  void apply(const std::uint16_t* reported_mm, std::size_t count, std::uint16_t* true_mm) const;

 private:
  std::vector<std::uint16_t> true_of_reported_mm_;  // 65536 of them
};

}  // namespace g3d::hal::kinect
