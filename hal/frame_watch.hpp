// SPDX-License-Identifier: Apache-2.0
// Whether a depth image is a proof that the camera sees: the safety table counts only those. A camera that hangs may
// repeat its last image, one with a bad cable may send noise, and both look alive by their rate alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/messages.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

enum class FrameFault : std::uint8_t {
  none,
  old,      ///< taken too long ago, in the future, or not later than the one before
  stuck,    ///< the same as before, though the base has moved
  garbage,  ///< most neighbouring pixels contradict each other
  count_,
};
[[nodiscard]] const char* to_string(FrameFault fault);

struct FrameWatchOptions {
  TimeNs max_age_ns = 300'000'000;
  double moved_m = 0.03;  ///< what the base must have moved for two equal images to be wrong
  double moved_rad = 0.03;
};

/// One thread. Allocates nothing.
class FrameWatch {
 public:
  explicit FrameWatch(const FrameWatchOptions& options = {}) : options_(options) {}
  /// `T_world_base`: where the base is, by odometry. Looks at every pixel of the depth image once. An image without a
  /// single reading is what a camera in front of a near wall gives: it is neither stuck nor garbage.
  [[nodiscard]] FrameFault check(const Frame& frame, const CameraModel& camera, const PlanarPose& T_world_base,
                                 TimeNs now_ns);
  [[nodiscard]] const std::array<std::uint64_t, static_cast<std::size_t>(FrameFault::count_)>& counts() const {
    return counts_;
  }

 private:
  [[nodiscard]] FrameFault look(const Frame& frame, const CameraModel& camera, const PlanarPose& T_world_base,
                                TimeNs now_ns);
  [[nodiscard]] bool is_stuck(std::uint64_t digest, const PlanarPose& T_world_base);

  const FrameWatchOptions options_;
  bool had_frame_ = false;
  TimeNs last_stamp_ns_ = 0;
  std::uint64_t last_digest_ = 0;
  PlanarPose first_equal_;  // where the base was at the first of the equal images
  std::array<std::uint64_t, static_cast<std::size_t>(FrameFault::count_)> counts_{};
};

}  // namespace g3d::hal
