// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/point_to_plane.hpp"

namespace g3d::mapper::align {
namespace {
// Surfaces that face more than 37 degrees apart are not the same one.
constexpr float kLeastCosineOfNormals = 0.8F;
}  // namespace

NormalSums match(std::span<const DepthSample> samples, const SurfaceMap& surfaces, const hal::Pose& T_world_camera,
                 float kernel_m, hal::TimeNs born_by_ns) {
  NormalSums sums;
  const hal::RigidTransform T = hal::to_transform(T_world_camera);
  const float ceiling = kernel_m * kernel_m;
  for (const DepthSample& sample : samples) {
    const Vector3f arm = rotated(T, sample.point_m);
    const Vector3f n = rotated(T, sample.normal);
    const Vector3f at{arm[0] + T.translation_m[0], arm[1] + T.translation_m[1], arm[2] + T.translation_m[2]};
    const auto piece = surfaces.find(at, n, born_by_ns);
    if (!piece || dot(piece->normal, n) < kLeastCosineOfNormals) continue;
    const Vector3f& f = piece->normal;
    const float r = dot(f, {at[0] - piece->point_m[0], at[1] - piece->point_m[1], at[2] - piece->point_m[2]});
    const float share = ceiling / (ceiling + r * r);
    const std::array<float, 6> j{
        f[0], f[1], f[2], arm[1] * f[2] - arm[2] * f[1], arm[2] * f[0] - arm[0] * f[2], arm[0] * f[1] - arm[1] * f[0]};
    sums.add(j, r, sample.weight * share * share);
    sums.add_cost(sample.weight * r * r * share);
  }
  return sums;
}

}  // namespace g3d::mapper::align
