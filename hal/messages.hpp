// SPDX-License-Identifier: Apache-2.0
// What threads hand to each other. Plain values with fixed size after start-up; image storage belongs to a FramePool.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "hal/geometry.hpp"

namespace g3d::hal {

/// Nanoseconds since the source's epoch; real clocks are monotonic, logs use the log's own time.
using TimeNs = std::int64_t;
inline constexpr TimeNs kMillisecond_ns = 1'000'000;

/// Pinhole intrinsics and depth scale of one camera; colour is registered to depth.
struct CameraModel {
  int width_px = 640;
  int height_px = 480;
  float fx_px = 525.0F;
  float fy_px = 525.0F;
  float cx_px = 319.5F;
  float cy_px = 239.5F;
  float depth_units_per_metre = 1000.0F;  ///< depth_m = raw / depth_units_per_metre; raw 0 = no reading

  [[nodiscard]] std::size_t pixel_count() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
  bool operator==(const CameraModel&) const = default;
};

/// Largest image that any part accepts: everything from outside is bounded by it.
inline constexpr int kMaxImageSide_px = 2048;

/// One depth image and, if `has_colour`, the colour image registered to it. Row-major, pixel index = v * width + u.
struct Frame {
  TimeNs stamp_ns = 0;
  std::uint64_t sequence = 0;  ///< counted by the camera, gaps are frames it lost itself
  bool has_colour = false;
  std::unique_ptr<std::uint16_t[]> depth;  ///< width * height raw readings
  std::unique_ptr<std::uint8_t[]> rgb;     ///< 3 * width * height bytes R G B
};

/// Why a frame that the camera delivered did not reach the map. Every one is counted; `to_string` names it in the
/// report.
enum class DropReason : std::uint8_t {
  unreadable_depth,  ///< missing, truncated or lying image file
  wrong_size,        ///< image of another size than the camera model
  no_pose,           ///< no pose within the allowed time of the frame
  bad_pose,          ///< pose with NaN or without a unit quaternion
  time_backwards,    ///< stamp not later than that of the frame before
  queue_full,        ///< real time only: the mapper was behind
  out_of_range,      ///< the pose lies outside of what 16 bits per axis can address
  map_moving,        ///< the map was being put right as a whole, and the robot stood
  interrupted,       ///< asked to stop while the frame was under way
  count_,
};
inline constexpr std::size_t kDropReasonCount = static_cast<std::size_t>(DropReason::count_);
[[nodiscard]] const char* to_string(DropReason reason);

/// A frame (by its index in the FramePool) with the pose it was taken from.
struct PosedFrame {
  std::uint32_t frame_index = 0;
  Pose T_world_camera;
};

}  // namespace g3d::hal
