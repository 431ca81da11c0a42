// SPDX-License-Identifier: Apache-2.0
// A camera's way through a world, as a text file: one waypoint per line, `#` begins a comment.
//
//   t_s  x  y  z  yaw_deg  pitch_deg
//
// t_s ascends; x y z are metres in the world. yaw 0 looks along +x, 90 along +y (left); pitch is the elevation of the
// optical axis: -10 looks 10 degrees down. Between waypoints every coordinate follows a monotone cubic (Fritsch and
// Carlson 1980): smooth, never beyond the two waypoints that it lies between; yaw takes the shorter way round.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

inline constexpr std::size_t kMaxPathWaypoints = 100000;

struct PathWaypoint {
  double t_s = 0.0;
  std::array<double, 5> x_y_z_yaw_pitch{};  ///< m, m, m, deg, deg
};

class CameraPath {
 public:
  /// At least one waypoint, ascending t_s.
  explicit CameraPath(const std::vector<PathWaypoint>& waypoints);

  [[nodiscard]] TimeNs begin_ns() const;
  [[nodiscard]] TimeNs end_ns() const;
  /// T_world_camera; before the first waypoint and after the last, the camera rests there.
  [[nodiscard]] Pose pose_at(TimeNs time_ns) const;
  /// The same way `count` times in a row, at least once; where it does not end at its beginning, the camera flies
  /// there.
  [[nodiscard]] CameraPath laps(int count) const;

 private:
  struct Knot {
    double t_s = 0.0;
    std::array<double, 5> value{};  ///< yaw unwrapped: neighbours differ by at most 180 degrees
    std::array<double, 5> slope{};  ///< per second
  };
  std::vector<Knot> knots_;
};

/// Pose of a camera (optical frame: x right, y down, z forward) at a place, looking along yaw and elevation.
[[nodiscard]] Pose camera_pose(const std::array<double, 3>& eye_m, double yaw_deg, double pitch_deg);

/// `file` is what errors call the text.
[[nodiscard]] Result<CameraPath> parse_camera_path(std::string_view text, std::string_view file);

}  // namespace g3d::hal
