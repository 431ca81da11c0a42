// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/world_query.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
using Vec3 = std::array<double, 3>;

/// Part of a ray, in ray parameters; empty if from > to.
struct Interval {
  double from = -kNever;
  double to = kNever;
};

void clip(Interval& part, double from, double to) {
  part.from = std::max(part.from, from);
  part.to = std::min(part.to, to);
}

/// Clips to |o + t d| <= half along one axis.
void clip_slab(Interval& part, double o, double d, double half) {
  if (d == 0.0) {
    if (std::abs(o) > half) part = {1.0, -1.0};
    return;
  }
  const double a = (-half - o) / d;
  const double b = (half - o) / d;
  clip(part, std::min(a, b), std::max(a, b));
}

Vec3 local_point(const Primitive& solid, const Vec3& p) {
  const double x = p[0] - solid.centre_m[0];
  const double y = p[1] - solid.centre_m[1];
  const double c = solid.cos_yaw;
  const double s = solid.sin_yaw;
  return {c * x + s * y, -s * x + c * y, p[2] - solid.centre_m[2]};
}

Vec3 local_direction(const Primitive& solid, const Vec3& d) {
  const double c = solid.cos_yaw;
  const double s = solid.sin_yaw;
  return {c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2]};
}

void clip_sphere(Interval& part, const Vec3& o, const Vec3& d, double radius) {
  const double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  const double b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
  const double c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - radius * radius;
  const double disc = b * b - a * c;
  if (disc < 0.0) {
    part = {1.0, -1.0};
    return;
  }
  clip(part, (-b - std::sqrt(disc)) / a, (-b + std::sqrt(disc)) / a);
}

/// Inside of x^2 + y^2 <= (radius at z)^2, where the radius changes linearly with z; a cylinder has slope 0.
void clip_cone(Interval& part, const Vec3& o, const Vec3& d, double radius_at_0, double slope) {
  const double radius = radius_at_0 + slope * o[2];
  const double a = d[0] * d[0] + d[1] * d[1] - slope * slope * d[2] * d[2];
  const double b = o[0] * d[0] + o[1] * d[1] - radius * slope * d[2];
  const double c = o[0] * o[0] + o[1] * o[1] - radius * radius;
  if (std::abs(a) < 1e-14) {
    if (b == 0.0) {
      if (c > 0.0) part = {1.0, -1.0};
    } else if (b > 0.0) {
      clip(part, -kNever, -c / (2 * b));
    } else {
      clip(part, -c / (2 * b), kNever);
    }
    return;
  }
  const double disc = b * b - a * c;
  if (disc < 0.0 && a > 0.0) {
    part = {1.0, -1.0};
    return;
  }
  const double root = std::sqrt(std::max(disc, 0.0));
  const double t0 = std::min((-b - root) / a, (-b + root) / a);
  const double t1 = std::max((-b - root) / a, (-b + root) / a);
  if (a > 0.0) return clip(part, t0, t1);
  // A ray steeper than the cone is inside of it on one side of the apex and inside of its mirror image on the other.
  if (d[2] * slope < 0.0) return clip(part, -kNever, t0);
  clip(part, t1, kNever);
}

double squared(double x) { return x * x; }

/// Distance by which a coordinate lies outside of [-half, half].
double outside(double x, double half) { return std::max(std::abs(x) - half, 0.0); }

double distance_to(const Primitive& solid, const Vec3& point_m) {
  const Vec3 p = local_point(solid, point_m);
  const double radial = std::sqrt(squared(p[0]) + squared(p[1]));
  switch (solid.shape) {
    case Shape::box:
      return std::sqrt(squared(outside(p[0], solid.half_m[0])) + squared(outside(p[1], solid.half_m[1])) +
                       squared(outside(p[2], solid.half_m[2])));
    case Shape::sphere:
      return outside(std::sqrt(squared(radial) + squared(p[2])), solid.radius_low_m);
    case Shape::cylinder:
    case Shape::cone:
      break;
  }
  return std::sqrt(squared(outside(radial, solid.half_m[0])) + squared(outside(p[2], solid.half_m[2])));
}

}  // namespace

double intersect(const Primitive& solid, const Vec3& origin_m, const Vec3& direction) {
  const Vec3 o = local_point(solid, origin_m);
  const Vec3 d = local_direction(solid, direction);
  Interval part;
  if (solid.shape != Shape::sphere) clip_slab(part, o[2], d[2], solid.half_m[2]);
  switch (solid.shape) {
    case Shape::box:
      clip_slab(part, o[0], d[0], solid.half_m[0]);
      clip_slab(part, o[1], d[1], solid.half_m[1]);
      break;
    case Shape::sphere:
      clip_sphere(part, o, d, solid.radius_low_m);
      break;
    case Shape::cylinder:
      clip_cone(part, o, d, solid.radius_low_m, 0.0);
      break;
    case Shape::cone: {
      const double slope = (static_cast<double>(solid.radius_high_m) - solid.radius_low_m) / (2.0 * solid.half_m[2]);
      clip_cone(part, o, d, solid.radius_low_m + slope * solid.half_m[2], slope);
      break;
    }
  }
  if (part.from > part.to || part.to < 0.0) return kNever;
  return std::max(part.from, 0.0);
}

RayHit cast_ray(const World& world, TimeNs time_ns, const Vec3& origin_m, const Vec3& direction, bool with_glass) {
  RayHit nearest;
  for (std::size_t i = 0; i < world.primitives().size(); ++i) {
    if (world.primitives()[i].material.glass && !with_glass) continue;
    const double t = intersect(world.placed(i, time_ns), origin_m, direction);
    if (t < nearest.t) nearest = {t, i};
  }
  if (world.grid()) {
    const std::array<float, 3> o = {static_cast<float>(origin_m[0]), static_cast<float>(origin_m[1]),
                                    static_cast<float>(origin_m[2])};
    const std::array<float, 3> d = {static_cast<float>(direction[0]), static_cast<float>(direction[1]),
                                    static_cast<float>(direction[2])};
    const float limit = nearest.t < GridWalls::kMiss ? static_cast<float>(nearest.t) : GridWalls::kMiss;
    const GridWalls::Hit hit = world.grid()->cast(o, d, limit);
    if (hit.t < limit) nearest = {hit.t, RayHit::kGrid};
  }
  return nearest;
}

bool is_solid(const World& world, TimeNs time_ns, const Vec3& point_m) {
  if (world.grid() && world.grid()->is_solid(static_cast<float>(point_m[0]), static_cast<float>(point_m[1]),
                                             static_cast<float>(point_m[2]))) {
    return true;
  }
  for (std::size_t i = 0; i < world.primitives().size(); ++i) {
    const Primitive solid = world.placed(i, time_ns);
    // From inside of a convex solid every ray starts inside; the direction does not matter.
    if (distance_to(solid, point_m) == 0.0 && intersect(solid, point_m, {1.0, 0.0, 0.0}) == 0.0) return true;
  }
  return false;
}

double clearance_m(const World& world, TimeNs time_ns, const Vec3& point_m) {
  double nearest_m = kNever;
  for (std::size_t i = 0; i < world.primitives().size(); ++i) {
    nearest_m = std::min(nearest_m, distance_to(world.placed(i, time_ns), point_m));
  }
  return nearest_m;
}

}  // namespace g3d::hal
