// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/robot_body.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/sim/plain_trig.hpp"

namespace g3d::hal {
namespace {

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kGripPeriod_s = 0.5;
constexpr double kTouch_m = 0.0005;     // nearer than this counts as touching
constexpr double kCliffDepth_m = 0.05;  // Kobuki does not drive off cliffs of more than 5 cm
constexpr double kDropDepth_m = 0.03;   // a wheel hangs out of its case by about as much
constexpr double kSidewaysSin = 0.5;    // the bumper's middle third ends at 30 degrees (kobuki_gazebo)

/// Where the parts are, base frame (kobuki_description): cliff sensors right, centre, left; wheels right, left.
struct Part {
  double x_m;
  double y_m;
  std::uint8_t bit;
};
constexpr Part kCliffSensors[] = {
    {0.087, -0.136, kobuki::kCliffRight}, {0.156, 0.0, kobuki::kCliffCentre}, {0.087, 0.136, kobuki::kCliffLeft}};
constexpr Part kWheels[] = {{0.0, -0.115, kobuki::kWheelDropRight}, {0.0, 0.115, kobuki::kWheelDropLeft}};

double wrapped(double angle_rad) {
  while (angle_rad > std::numbers::pi) angle_rad -= 2.0 * std::numbers::pi;
  while (angle_rad <= -std::numbers::pi) angle_rad += 2.0 * std::numbers::pi;
  return angle_rad;
}

}  // namespace

RobotBody::RobotBody(const FloorContact& floor, const PlanarPose& T_world_base, std::int32_t own_mover,
                     const RobotBodyOptions& options)
    : floor_(floor),
      options_(options),
      own_mover_(own_mover),
      dynamics_(options.dynamics),
      random_(options.seed),
      T_world_base_(T_world_base) {}

void RobotBody::place(const PlanarPose& T_world_base, MoverPlaces places_m) {
  T_world_base_ = T_world_base;
  dynamics_.force_speeds({});
  velocity_ = {};
  sense_.stalled = false;
  feel(places_m);
}

void RobotBody::step(double dt_s, MoverPlaces places_m) {
  const WheelPair way_m = dynamics_.step(dt_s);
  if (sense_.wheel_drop != 0) {
    // The body rests on its edge; wheels turn in the air.
    way_m_ = {way_m_.left + way_m.left, way_m_.right + way_m.right};
    velocity_ = {};
    sense_.stalled = false;
  } else {
    roll(way_m, dt_s, places_m);
  }
  feel(places_m);
}

void RobotBody::roll(const WheelPair& way_m, double dt_s, MoverPlaces places_m) {
  if (options_.slip > 0.0) {
    grip_age_s_ += dt_s;
    if (grip_age_s_ >= kGripPeriod_s) {
      grip_ = {1.0 - options_.slip * random_.gaussian(), 1.0 - options_.slip * random_.gaussian()};
      grip_age_s_ = 0.0;
    }
  }
  const double left_m = way_m.left * grip_.left;
  const double right_m = way_m.right * grip_.right;
  const double turn_rad = (right_m - left_m) / kobuki::kWheelBase_m;
  double forward_m = (left_m + right_m) / 2.0;
  const SinCos middle = sin_cos_deg((T_world_base_.heading_rad + turn_rad / 2.0) * kDegPerRad);

  const auto clearance_after = [&](double way) {
    return clearance_at(T_world_base_.x_m + way * middle.cos, T_world_base_.y_m + way * middle.sin, places_m);
  };
  bool held = false;
  if (forward_m != 0.0 && clearance_after(forward_m) < 0.0) {
    // Out of something that came too near (a person) it may always back away.
    const double here_m = clearance_at(T_world_base_.x_m, T_world_base_.y_m, places_m);
    if (here_m >= 0.0 || clearance_after(forward_m) <= here_m) {
      held = true;
      double free_fraction = 0.0;
      double blocked_fraction = 1.0;
      for (int i = 0; i < 10 && here_m >= 0.0; ++i) {
        const double fraction = (free_fraction + blocked_fraction) / 2.0;
        (clearance_after(fraction * forward_m) >= 0.0 ? free_fraction : blocked_fraction) = fraction;
      }
      forward_m *= free_fraction;
    }
  }
  T_world_base_.x_m += forward_m * middle.cos;
  T_world_base_.y_m += forward_m * middle.sin;
  T_world_base_.heading_rad = wrapped(T_world_base_.heading_rad + turn_rad);
  turned_rad_ += turn_rad;
  driven_m_ += std::abs(forward_m);
  velocity_ = {forward_m / dt_s, turn_rad / dt_s};
  sense_.stalled = held;
  if (held) {
    // The wheels stand as far as the body does.
    const double half_m = turn_rad * kobuki::kWheelBase_m / 2.0;
    const WheelPair real_m = {forward_m - half_m, forward_m + half_m};
    dynamics_.force_speeds({real_m.left / dt_s, real_m.right / dt_s});
    way_m_ = {way_m_.left + real_m.left, way_m_.right + real_m.right};
  } else {
    way_m_ = {way_m_.left + way_m.left, way_m_.right + way_m.right};
  }
}

double RobotBody::clearance_at(double x_m, double y_m, MoverPlaces places_m) const {
  const auto thing = floor_.nearest(x_m, y_m, {kClimb_m, options_.height_m}, places_m, own_mover_);
  return std::min(thing.at.distance_m, FloorContact::kReach_m) - options_.radius_m;
}

void RobotBody::feel(MoverPlaces places_m) {
  const double x_m = T_world_base_.x_m;
  const double y_m = T_world_base_.y_m;
  const auto thing = floor_.nearest(x_m, y_m, {kClimb_m, options_.height_m}, places_m, own_mover_);
  sense_.clearance_m = std::min(thing.at.distance_m, FloorContact::kReach_m) - options_.radius_m;
  sense_.touching = sense_.clearance_m < kTouch_m;
  sense_.touched = sense_.touching ? thing : FloorContact::Thing{};

  const SinCos heading = sin_cos_deg(T_world_base_.heading_rad * kDegPerRad);
  sense_.bumper = 0;
  if (sense_.clearance_m < options_.bumper_travel_m) {
    floor_.for_near(x_m, y_m, options_.radius_m + options_.bumper_travel_m, options_.bumper, places_m, own_mover_,
                    [&](const FloorContact::Thing& near) {
                      const double dx = near.at.x_m - x_m;
                      const double dy = near.at.y_m - y_m;
                      const double ahead = heading.cos * dx + heading.sin * dy;
                      const double left = heading.cos * dy - heading.sin * dx;
                      if (ahead < 0.0) return;  // the plate covers the front half
                      const double sideways = kSidewaysSin * near.at.distance_m;
                      sense_.bumper |= left > sideways    ? kobuki::kBumperLeft
                                       : left < -sideways ? kobuki::kBumperRight
                                                          : kobuki::kBumperCentre;
                    });
  }
  const auto floor_below = [&](const Part& part) {
    return floor_.floor_m(x_m + heading.cos * part.x_m - heading.sin * part.y_m,
                          y_m + heading.sin * part.x_m + heading.cos * part.y_m);
  };
  sense_.cliff = 0;
  for (const Part& sensor : kCliffSensors) {
    if (floor_below(sensor) < -kCliffDepth_m) sense_.cliff |= sensor.bit;
  }
  sense_.wheel_drop = 0;
  for (const Part& wheel : kWheels) {
    if (floor_below(wheel) < -kDropDepth_m) sense_.wheel_drop |= wheel.bit;
  }
}

}  // namespace g3d::hal
