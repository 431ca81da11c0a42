// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/plan_shape.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

/// Largest radius that a round solid has between two heights; negative if it has none.
double radius_in(const Primitive& solid, double low_m, double high_m) {
  const double z = solid.centre_m[2];
  const double low = solid.radius_low_m;
  if (solid.shape == Shape::cylinder) return low;
  if (solid.shape == Shape::sphere) {
    const double off = std::max({low_m - z, z - high_m, 0.0});
    return off > low ? -1.0 : std::sqrt(low * low - off * off);
  }
  const double high = solid.radius_high_m;
  const double height_m = 2.0 * double{solid.half_m[2]};
  const double under_m = underside_m(solid);
  const auto at = [&](double level_m) {
    return low + (high - low) * std::clamp((level_m - under_m) / height_m, 0.0, 1.0);
  };
  return std::max(at(low_m), at(high_m));
}

PlanPoint nearest_of_disc(double x_m, double y_m, double centre_x_m, double centre_y_m, double radius_m) {
  const double dx = x_m - centre_x_m;
  const double dy = y_m - centre_y_m;
  const double d = std::sqrt(dx * dx + dy * dy);
  if (d <= radius_m) return {0.0, x_m, y_m};
  return {d - radius_m, centre_x_m + dx / d * radius_m, centre_y_m + dy / d * radius_m};
}

}  // namespace

PlanPoint nearest_in_plan(const Primitive& solid, const HeightSlice& slice, double x_m, double y_m) {
  if (underside_m(solid) > slice.high_m || upper_side_m(solid) < slice.low_m) return {};
  if (solid.shape != Shape::box) {
    const double radius_m = radius_in(solid, slice.low_m, slice.high_m);
    if (radius_m < 0.0) return {};
    return nearest_of_disc(x_m, y_m, solid.centre_m[0], solid.centre_m[1], radius_m);
  }
  const double c = solid.cos_yaw;
  const double s = solid.sin_yaw;
  const double dx = x_m - double{solid.centre_m[0]};
  const double dy = y_m - double{solid.centre_m[1]};
  const double u = c * dx + s * dy;
  const double v = c * dy - s * dx;
  const double u_near = std::clamp(u, -double{solid.half_m[0]}, double{solid.half_m[0]});
  const double v_near = std::clamp(v, -double{solid.half_m[1]}, double{solid.half_m[1]});
  const double du = u - u_near;
  const double dv = v - v_near;
  return {std::sqrt(du * du + dv * dv), double{solid.centre_m[0]} + c * u_near - s * v_near,
          double{solid.centre_m[1]} + s * u_near + c * v_near};
}

PlanExtent plan_extent(const Primitive& solid) {
  if (solid.shape != Shape::box) return {solid.half_m[0], solid.half_m[1]};
  const double c = std::abs(double{solid.cos_yaw});
  const double s = std::abs(double{solid.sin_yaw});
  return {c * double{solid.half_m[0]} + s * double{solid.half_m[1]},
          s * double{solid.half_m[0]} + c * double{solid.half_m[1]}};
}

}  // namespace g3d::hal
