// SPDX-License-Identifier: Apache-2.0
// Depth as the colour camera would see it, out of depth as the infrared camera saw it: every reading is moved to where
// its point lies in the colour image. For sources that do not register depth themselves. Where two readings fall on one
// pixel the nearer one stays; where none does there is none.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/kinect/calibration.hpp"

namespace g3d::hal::kinect {

class DepthRegistration {
 public:
  explicit DepthRegistration(const Calibration& calibration);
  /// 640 x 480 millimetres each; not in place. Allocates nothing.
  void apply(const std::uint16_t* infrared_mm, std::uint16_t* colour_mm) const;

 private:
  struct Ray {
    float x, y, z;  // of the infrared pixel at depth 1, turned into the colour camera's frame
  };
  std::vector<Ray> rays_;
  float shift_mm_[3];
  Intrinsics colour_;
};

}  // namespace g3d::hal::kinect
