// SPDX-License-Identifier: Apache-2.0
#include "nav/senses.hpp"

#include "nav/placing.hpp"

namespace g3d::nav {
namespace {

hal::Pose on_floor(const hal::PlanarPose& p) { return hal::from_xyz_rpy(p.x_m, p.y_m, 0.0, 0.0, 0.0, p.heading_rad); }

Sight refused(hal::DropReason reason) {
  Sight sight;
  sight.refused = reason;
  return sight;
}

}  // namespace

hal::PlanarPose Senses::in_world(const hal::PlanarPose& T_odometry_base) const {
  return compose(config_.T_world_start, T_odometry_base);
}

Sight Senses::look(const hal::Frame& frame, const hal::kobuki::PoseHistory& poses, hal::TimeNs now) {
  if (last_stamp_ns_ && frame.stamp_ns <= *last_stamp_ns_) return refused(hal::DropReason::time_backwards);
  last_stamp_ns_ = frame.stamp_ns;
  const auto T_odometry_base = poses.at(frame.stamp_ns);
  if (!T_odometry_base) return refused(hal::DropReason::no_pose);
  Sight sight;
  sight.T_world_base = in_world(*T_odometry_base);
  const hal::FrameFault fault = frame_watch_.check(frame, config_.camera, sight.T_world_base, now);
  sight.is_alive = fault == hal::FrameFault::none;
  if (fault == hal::FrameFault::garbage || fault == hal::FrameFault::stuck) {
    return refused(hal::DropReason::unreadable_depth);
  }
  sight.T_world_camera = hal::compose(on_floor(sight.T_world_base), config_.T_base_camera);
  return sight;
}

BaseView Senses::feel(const hal::kobuki::BaseState& base, const hal::PlanarPose& T_world_odometry) const {
  BaseView view;
  view.T_world_base = compose(T_world_odometry, in_world(base.T_world_base));
  view.velocity = base.velocity;
  view.bumper = base.bumper;
  view.cliff = base.cliff;
  view.verdict = base.verdict;
  view.energy_left_s = base.energy_left_s;
  return view;
}

bool Senses::feels_battery_low(const hal::kobuki::BaseState& base) {
  if (had_low_battery_ || base.battery_level == hal::kobuki::BatteryLevel::healthy) return false;
  had_low_battery_ = true;
  return true;
}

}  // namespace g3d::nav
