// SPDX-License-Identifier: Apache-2.0
// A solid as an upright robot meets it: the part of it between two heights, seen from above. All shapes are convex and
// upright, so the nearest point of that part is plain geometry in the plane.
#pragma once

#include <limits>

#include "hal/sim/world.hpp"

namespace g3d::hal {

/// Heights above the floor, metres.
struct HeightSlice {
  double low_m = 0.0;
  double high_m = 0.0;
};

struct PlanPoint {
  double distance_m = std::numeric_limits<double>::infinity();  ///< 0 inside
  double x_m = 0.0;                                             ///< the nearest point itself, world frame
  double y_m = 0.0;
};

/// Nearest point to (x, y) of what the solid has in the slice, edges included; infinitely far if it has nothing there.
[[nodiscard]] PlanPoint nearest_in_plan(const Primitive& solid, const HeightSlice& slice, double x_m, double y_m);

[[nodiscard]] inline double underside_m(const Primitive& p) { return double{p.centre_m[2]} - double{p.half_m[2]}; }
[[nodiscard]] inline double upper_side_m(const Primitive& p) { return double{p.centre_m[2]} + double{p.half_m[2]}; }

/// Half the sides of the axis-aligned rectangle around the solid's plan.
struct PlanExtent {
  double x_m = 0.0;
  double y_m = 0.0;
};
[[nodiscard]] PlanExtent plan_extent(const Primitive& solid);

}  // namespace g3d::hal
