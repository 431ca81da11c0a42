// SPDX-License-Identifier: Apache-2.0
// Rays of every kind for tests: into the map, along axes and edges, out of the grid, without end, and such that are
// none.
#pragma once

#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "mapper/ray_walk.hpp"
#include "tests/support/sample_maps.hpp"

namespace g3d::test {

inline std::vector<mapper::BulkRay> random_rays(std::uint64_t seed, std::size_t count, float resolution_m,
                                                double reach_m) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  tests::Random random(seed);
  std::vector<mapper::BulkRay> rays(count);
  for (mapper::BulkRay& ray : rays) {
    for (float& x : ray.origin_m) x = static_cast<float>(random.uniform(-reach_m, reach_m));
    for (float& d : ray.direction) d = static_cast<float>(random.uniform(-1.0, 1.0));
    ray.max_range_m = static_cast<float>(random.uniform(0.0, 2.0 * reach_m));
    ray.stop_at_unknown = random.below(2);
    const std::uint32_t kind = random.below(40);
    const std::uint32_t axis = random.below(3);
    if (kind < 4) ray.direction[axis] = 0.0F;
    if (kind == 1 || kind == 5) ray.direction[(axis + 1) % 3] = 0.0F;
    if (kind == 6) {  // from a face, along the diagonal of voxels
      for (float& x : ray.origin_m) x = static_cast<float>(static_cast<int>(x / resolution_m)) * resolution_m;
      for (float& d : ray.direction) d = d < 0.0F ? -1.0F : 1.0F;
    }
    if (kind == 7) ray.max_range_m = kInfinite;
    if (kind == 8) ray.max_range_m = random.below(2) == 0 ? kNan : -1.0F;
    if (kind == 9) ray.origin_m[axis] = random.below(2) == 0 ? kNan : kInfinite;
    if (kind == 10) ray.direction[axis] = random.below(2) == 0 ? kNan : kInfinite;
    if (kind == 11) ray.direction[0] = ray.direction[1] = ray.direction[2] = 0.0F;
    if (kind == 12) ray.direction[axis] *= 1e-12F;  // moves along it by nothing
    if (kind == 13) ray.origin_m[axis] = 32767.99F * resolution_m * (random.below(2) == 0 ? 1.0F : -1.0F);
    if (kind == 14) ray.origin_m[axis] = 40000.0F * resolution_m;
    if (kind == 15) {
      for (float& d : ray.direction) d *= 1e12F;
    }
  }
  return rays;
}

inline bool same_hits(std::span<const mapper::BulkHit> a, std::span<const mapper::BulkHit> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

}  // namespace g3d::test
