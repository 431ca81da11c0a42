// SPDX-License-Identifier: Apache-2.0
// One robot's body in a world: an upright cylinder that the wheels push over the floor. It never passes through
// anything; what it touches, what lies under its sensors and how near it came is known exactly. Turning on the spot
// moves nothing that could touch, so only the way forward can be blocked.
#pragma once

#include <cstdint>

#include "hal/kobuki/feedback.hpp"
#include "hal/sim/base_dynamics.hpp"
#include "hal/sim/floor_contact.hpp"
#include "hal/sim/seeded_random.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

struct RobotBodyOptions {
  double radius_m = kobuki::kBodyRadius_m;
  double height_m = 0.60;          ///< with the camera's mast
  double slip = 0.0;               ///< sigma of the fraction of its way that a wheel loses, redrawn twice a second
  std::uint64_t seed = 1;          ///< of the slip
  HeightSlice bumper{0.05, 0.11};  ///< where the bumper plate is
  double bumper_travel_m = 0.003;  ///< pressed while something is nearer than this
  BaseDynamicsOptions dynamics;
};

/// What the body's sensors say now.
struct BodySense {
  std::uint8_t bumper = 0;  ///< bits as in kobuki::Feedback
  std::uint8_t cliff = 0;
  std::uint8_t wheel_drop = 0;
  bool stalled = false;         ///< the wheels push and something holds the body
  FloorContact::Thing touched;  ///< nearest thing while `touching`
  bool touching = false;        ///< anything, also above or below the bumper
  double clearance_m = 0.0;     ///< free way to the nearest thing, at most FloorContact::kReach_m - radius
};

class RobotBody {
 public:
  /// `floor` must outlive this. `own_mover`: which mover of the world this body is (-1: none), so that it does not meet
  /// itself.
  RobotBody(const FloorContact& floor, const PlanarPose& T_world_base, std::int32_t own_mover,
            const RobotBodyOptions& options);

  void command(std::int16_t speed_mmps, std::int16_t radius_mm) { dynamics_.command(speed_mmps, radius_mm); }
  /// One step of 1..20 ms. Allocates nothing.
  void step(double dt_s, MoverPlaces places_m);
  /// Puts it somewhere else, standing.
  void place(const PlanarPose& T_world_base, MoverPlaces places_m);

  [[nodiscard]] const PlanarPose& T_world_base() const { return T_world_base_; }
  [[nodiscard]] double turned_rad() const { return turned_rad_; }        ///< since the start, not wrapped
  [[nodiscard]] double driven_m() const { return driven_m_; }            ///< length of the path of its centre
  [[nodiscard]] const WheelPair& wheel_way_m() const { return way_m_; }  ///< since the start, what encoders count
  [[nodiscard]] Twist velocity() const { return velocity_; }
  [[nodiscard]] const WheelPair& wheel_speeds_mps() const { return dynamics_.speeds_mps(); }
  [[nodiscard]] const BodySense& sense() const { return sense_; }

 private:
  void roll(const WheelPair& way_m, double dt_s, MoverPlaces places_m);
  [[nodiscard]] double clearance_at(double x_m, double y_m, MoverPlaces places_m) const;
  void feel(MoverPlaces places_m);

  const FloorContact& floor_;
  RobotBodyOptions options_;
  std::int32_t own_mover_;
  BaseDynamics dynamics_;
  SeededRandom random_;
  PlanarPose T_world_base_;
  WheelPair way_m_;
  WheelPair grip_{1.0, 1.0};
  double grip_age_s_ = 1e9;
  double turned_rad_ = 0.0;
  double driven_m_ = 0.0;
  Twist velocity_;
  BodySense sense_;
};

}  // namespace g3d::hal
