// SPDX-License-Identifier: Apache-2.0
// What a robot's camera and base say, put into the frame of its world: what a frame is worth and where it was taken,
// and what the navigator is to know of the base. The same in lockstep (robot.hpp) and in threads (robot_threads.hpp).
#pragma once

#include <optional>

#include "hal/frame_watch.hpp"
#include "hal/kobuki/base_state.hpp"
#include "hal/kobuki/pose_history.hpp"
#include "hal/messages.hpp"
#include "nav/navigator.hpp"

namespace g3d::nav {

struct SensesConfig {
  hal::CameraModel camera;
  hal::Pose T_base_camera;
  hal::PlanarPose T_world_start;  ///< where odometry begins
  hal::FrameWatchOptions frame_watch;
};

/// One frame, judged.
struct Sight {
  std::optional<hal::DropReason> refused;  ///< why it must not go into the map
  bool is_alive = false;                   ///< the safety table may count it: the camera sees
  hal::PlanarPose T_world_base;            ///< at the frame's stamp; these two only if it is not refused
  hal::Pose T_world_camera;
};

class Senses {
 public:
  explicit Senses(const SensesConfig& config) : config_(config), frame_watch_(config.frame_watch) {}

  /// One thread, in the order of the frames; looks at every pixel once, allocates nothing. `poses`: of odometry.
  [[nodiscard]] Sight look(const hal::Frame& frame, const hal::kobuki::PoseHistory& poses, hal::TimeNs now);
  /// Any thread. `T_world_odometry`: how far odometry has gone astray (placing.hpp).
  [[nodiscard]] BaseView feel(const hal::kobuki::BaseState& base, const hal::PlanarPose& T_world_odometry = {}) const;
  /// True once, when the base says for the first time that it is time to go home. One thread.
  [[nodiscard]] bool feels_battery_low(const hal::kobuki::BaseState& base);
  /// As odometry has it.
  [[nodiscard]] hal::PlanarPose in_world(const hal::PlanarPose& T_odometry_base) const;

 private:
  const SensesConfig config_;
  hal::FrameWatch frame_watch_;
  std::optional<hal::TimeNs> last_stamp_ns_;
  bool had_low_battery_ = false;
};

}  // namespace g3d::nav
