// SPDX-License-Identifier: Apache-2.0
// One depth image as a fan of rays over the floor: what each meets first at the height of the robot's body, and how far
// it passes. Unlike the map it takes every reading, also those nearer than the map trusts, and at once: somebody who
// walks changes no voxel before he stands still.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"

namespace g3d::nav {

struct DepthScanConfig {
  hal::Pose T_base_camera = {{0.0, 0.0, 0.5}, {-0.5, 0.5, -0.5, 0.5}};  ///< half a metre up, looking ahead
  double low_m = 0.10;                                                  ///< lower things may be noise on the floor
  double body_height_m = 0.6;                                           ///< it drives under what is higher
  double near_m = 0.3;                                                  ///< no Kinect reads less
  double far_m = 3.0;                                                   ///< what is farther has time
};

class DepthScan {
 public:
  static constexpr int kRays = 80;

  struct Ray {
    double bearing_rad = 0.0;  ///< as seen from the camera's place, base frame, left is positive
    double through_m = 0.0;    ///< from the camera's place on the floor: so far nothing stands in the way
    double floor_to_m = 0.0;   ///< from the image's lower edge on the floor is measured up to here; 0: not even there
    bool has_hit = false;
    double hit_x_m = 0.0;  ///< base frame
    double hit_y_m = 0.0;
  };

  explicit DepthScan(const DepthScanConfig& config);

  /// Allocates nothing; looks at a fixed number of pixels, whatever the image's size.
  void look(const hal::Frame& frame, const hal::CameraModel& camera);

  [[nodiscard]] const std::array<Ray, kRays>& rays() const { return rays_; }  ///< from left to right
  [[nodiscard]] double eye_x_m() const { return static_cast<double>(T_base_camera_.translation_m[0]); }
  [[nodiscard]] double eye_y_m() const { return static_cast<double>(T_base_camera_.translation_m[1]); }

 private:
  static constexpr int kRows = 60;

  [[nodiscard]] Ray scan_column(const hal::Frame& frame, const hal::CameraModel& camera, int u) const;

  DepthScanConfig config_;
  hal::RigidTransform T_base_camera_;
  std::array<Ray, kRays> rays_{};
};

}  // namespace g3d::nav
