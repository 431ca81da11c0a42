// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/depth_table.hpp"

#include <cmath>

namespace g3d::hal::kinect {

DepthTable::DepthTable(const Calibration& calibration) : true_of_reported_mm_(65536) {
  for (std::size_t mm = 1; mm <= kFarthest_mm; ++mm) {
    const double z_m = static_cast<double>(mm) / 1000.0;
    const double true_mm = 1000.0 * (calibration.depth_offset_m + calibration.depth_scale * z_m +
                                     calibration.depth_quadratic_perm * z_m * z_m);
    if (true_mm >= 0.5 && true_mm < 65535.0)
      true_of_reported_mm_[mm] = static_cast<std::uint16_t>(std::lround(true_mm));
  }
}

void DepthTable::apply(const std::uint16_t* reported_mm, std::size_t count, std::uint16_t* true_mm) const {
  for (std::size_t i = 0; i < count; ++i) true_mm[i] = true_of_reported_mm_[reported_mm[i]];
}

}  // namespace g3d::hal::kinect
