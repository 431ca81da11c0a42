// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/tile_kernels.hpp"

#include <cmath>

namespace g3d::hal {
namespace {

constexpr float kTinySlope =
    1e-20F;  // stands for a direction of zero: quotients stay finite, or become plain infinities

inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }
inline float off_zero(float d) { return d < 0.0F ? smaller(d, -kTinySlope) : larger(d, kTinySlope); }

struct RaySpan {
  float from;
  float to;
};

inline RaySpan slab(float origin, float direction, float half) {
  const float inverse = 1.0F / off_zero(direction);
  const float a = (-half - origin) * inverse;
  const float b = (half - origin) * inverse;
  return {smaller(a, b), larger(a, b)};
}

inline RaySpan common(RaySpan a, RaySpan b) { return {larger(a.from, b.from), smaller(a.to, b.to)}; }

/// For a ray along the axis of an upright solid: the roots become far away instead of undefined.
constexpr float kTinySquare = 1e-12F;

/// Roots of a t^2 + 2 b t + c <= 0 for a > 0, from a discriminant that was computed without cancellation.
inline RaySpan between_roots(float a, float b, float discriminant) {
  const float root = std::sqrt(larger(discriminant, 0.0F));
  const float inverse = 1.0F / a;
  const float nowhere = discriminant < 0.0F ? kNoDepth_m : 0.0F;
  return {(-b - root) * inverse + nowhere, (-b + root) * inverse - nowhere};
}

inline RaySpan box_interval(const PreparedSolid& s, float dx, float dy, float dz) {
  return common(common(slab(s.origin[0], dx, s.half[0]), slab(s.origin[1], dy, s.half[1])),
                slab(s.origin[2], dz, s.half[2]));
}

inline RaySpan sphere_interval(const PreparedSolid& s, float dx, float dy, float dz) {
  const float a = dx * dx + dy * dy + dz * dz;
  const float b = s.origin[0] * dx + s.origin[1] * dy + s.origin[2] * dz;
  // |o x d|^2 instead of |o|^2 |d|^2 - (o d)^2: the small difference of large numbers would drown a thin solid.
  const float cx = s.origin[1] * dz - s.origin[2] * dy;
  const float cy = s.origin[2] * dx - s.origin[0] * dz;
  const float cz = s.origin[0] * dy - s.origin[1] * dx;
  return between_roots(a, b, s.radius * s.radius * a - (cx * cx + cy * cy + cz * cz));
}

inline RaySpan cylinder_interval(const PreparedSolid& s, float dx, float dy, float dz) {
  const float a = larger(dx * dx + dy * dy, kTinySquare);
  const float b = s.origin[0] * dx + s.origin[1] * dy;
  const float cross = s.origin[0] * dy - s.origin[1] * dx;
  return common(between_roots(a, b, s.radius * s.radius * a - cross * cross), slab(s.origin[2], dz, s.half[2]));
}

inline RaySpan cone_interval(const PreparedSolid& s, float dx, float dy, float dz) {
  const float radius = s.radius + s.slope * s.origin[2];
  const float m = s.slope * dz;
  const float a = dx * dx + dy * dy - m * m;
  const float b = s.origin[0] * dx + s.origin[1] * dy - radius * m;
  const float cross = s.origin[0] * dy - s.origin[1] * dx;
  const float ux = s.origin[0] * m - radius * dx;
  const float uy = s.origin[1] * m - radius * dy;
  const float discriminant = ux * ux + uy * uy - cross * cross;
  const float steep = off_zero(a);
  const float root = std::sqrt(larger(discriminant, 0.0F));
  const float inverse = 1.0F / steep;
  const float r0 = (-b - root) * inverse;
  const float r1 = (-b + root) * inverse;
  const float low = smaller(r0, r1);
  const float high = larger(r0, r1);
  // A ray steeper than the cone is inside of it before or behind its apex, not between the roots.
  const bool towards_apex = m < 0.0F;
  const float nowhere = a > 0.0F && discriminant < 0.0F ? kNoDepth_m : 0.0F;
  const float from = a > 0.0F ? low : towards_apex ? -kNoDepth_m : high;
  const float to = a > 0.0F ? high : towards_apex ? low : kNoDepth_m;
  return common({from + nowhere, to - nowhere}, slab(s.origin[2], dz, s.half[2]));
}

template <typename IntervalOf>
inline void cast_all(const PreparedSolid& s, std::int32_t place, const TileRays& rays, TileHits& hits,
                     const IntervalOf& interval_of) {
  const float c = s.cos_yaw;
  const float sn = s.sin_yaw;
  for (std::size_t i = 0; i < kTilePixels; ++i) {
    const float dx = c * rays.x[i] + sn * rays.y[i];
    const float dy = c * rays.y[i] - sn * rays.x[i];
    const RaySpan part = interval_of(s, dx, dy, rays.z[i]);
    const float t = larger(part.from, 0.0F);
    const float before = hits.depth_m[i];
    const bool nearer = (part.from <= part.to) & (part.to >= 0.0F) & (t < before);
    hits.depth_m[i] = nearer ? t : before;
    hits.solid[i] = nearer ? place : hits.solid[i];
  }
}

}  // namespace

void cast_tile(const PreparedSolid& solid, std::int32_t place, const TileRays& rays, TileHits& hits) {
  switch (solid.shape) {
    case Shape::box:
      return cast_all(solid, place, rays, hits, box_interval);
    case Shape::sphere:
      return cast_all(solid, place, rays, hits, sphere_interval);
    case Shape::cylinder:
      return cast_all(solid, place, rays, hits, cylinder_interval);
    case Shape::cone:
      return cast_all(solid, place, rays, hits, cone_interval);
  }
}

}  // namespace g3d::hal
