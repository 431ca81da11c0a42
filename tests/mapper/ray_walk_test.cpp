// SPDX-License-Identifier: Apache-2.0
// The walk in float32 against cast_ray(), which is in double: the same voxels but where a ray passes an edge within a
// thousandth of a voxel.
#include "mapper/ray_walk.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mapper/cpu/bulk_rays.hpp"
#include "mapper/query.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

struct FreeEverywhere {
  [[nodiscard]] BlockLevels find(BlockKey) const { return {nullptr, 0}; }
};

/// By how many voxels a ray misses a voxel; 0 if it passes through.
double miss_cells(const BulkRay& ray, float resolution_m, const std::uint16_t (&voxel)[3], double range_m) {
  // The largest of the distances over all axes, at the best place along the ray: a ternary search over a convex
  // function.
  double length = 0.0;
  for (const float d : ray.direction) length += static_cast<double>(d) * static_cast<double>(d);
  length = std::sqrt(length);
  const auto r = static_cast<double>(resolution_m);
  const auto miss = [&](double s) {
    double worst = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = static_cast<double>(ray.origin_m[axis]) + s * static_cast<double>(ray.direction[axis]) / length;
      const double low = voxel[axis] - 32768.0;
      worst = std::max({worst, low - x / r, x / r - low - 1.0});
    }
    return worst;
  };
  double low = 0.0;
  double high = range_m + 2.0 * r;
  for (int i = 0; i < 200; ++i) {
    const double a = low + (high - low) / 3.0;
    const double b = high - (high - low) / 3.0;
    (miss(a) <= miss(b) ? high : low) = miss(a) <= miss(b) ? b : a;
  }
  return miss(low);
}

}  // namespace

TEST_CASE("rays in float32 find what rays in double find, but within a thousandth of a voxel of an edge") {
  cpu::ThreadPool pool(1);
  for (const float resolution_m : {0.05F, 0.01F}) {
    const double reach_m = 40.0 * static_cast<double>(resolution_m);
    const auto map = tests::random_map(91, 500, resolution_m);
    const std::vector<BulkRay> rays = test::random_rays(92, 6000, resolution_m, reach_m);
    std::vector<BulkHit> hits(rays.size());
    cpu::cast_bulk_rays(*map, rays, hits, pool);
    std::size_t different = 0;
    std::array<std::size_t, 4> ends{};
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const BulkRay& ray = rays[i];
      const BulkHit& hit = hits[i];
      const RayHit exact = cast_ray(*map, {ray.origin_m[0], ray.origin_m[1], ray.origin_m[2]},
                                    {ray.direction[0], ray.direction[1], ray.direction[2]},
                                    {static_cast<double>(ray.max_range_m), ray.stop_at_unknown != 0});
      INFO("ray " << i << " at " << resolution_m << " m");
      ++ends[static_cast<std::size_t>(hit.end)];
      const VoxelIndex voxel{hit.voxel[0], hit.voxel[1], hit.voxel[2]};
      const bool stops = hit.end == RayEnd::occupied || hit.end == RayEnd::unknown;
      if (hit.end == exact.end && (!stops || voxel == exact.voxel)) {
        if (std::isfinite(exact.distance_m)) {
          CHECK(static_cast<double>(hit.distance_m) == Approx(exact.distance_m).epsilon(1e-4).margin(1e-3 * reach_m));
        }
        continue;
      }
      // One that begins on faces is within rounding of several voxels; both may be right.
      const auto on_face = [&](float x_m) {
        const float x = x_m / resolution_m;
        return std::abs(x - std::round(x)) < 1e-3F;
      };
      different += on_face(ray.origin_m[0]) && on_face(ray.origin_m[1]) ? 0 : 1;
      if (!stops) continue;
      REQUIRE(state_of(map->at(voxel)) == (hit.end == RayEnd::occupied ? State::occupied : State::unknown));
      CHECK(miss_cells(ray, resolution_m, hit.voxel, static_cast<double>(hit.distance_m)) < 1e-3);
    }
    CHECK(different < rays.size() / 500);
    for (const std::size_t count : ends) CHECK(count > 50);
  }
}

TEST_CASE("a walk passes every voxel between its ends, one face at a time, and none beyond its range", "[long]") {
  tests::Random random(93);
  for (int i = 0; i < 500; ++i) {
    BulkRay ray{};
    for (float& x : ray.origin_m) x = static_cast<float>(random.uniform(-3, 3));
    for (float& d : ray.direction) d = static_cast<float>(random.uniform(-1, 1));
    const float range = static_cast<float>(random.uniform(0, 300));
    RayWalk w{};
    REQUIRE(begin_walk(w, ray.origin_m, ray.direction, 0.05F));
    std::array<std::int32_t, 3> last{w.cell[0], w.cell[1], w.cell[2]};
    float last_at = 0.0F;
    int cells = 0;
    CHECK(follow(w, range, FreeEverywhere{}, [&](const RayWalk& at, State state) {
            int steps = 0;
            for (std::size_t axis = 0; axis < 3; ++axis) steps += std::abs(at.cell[axis] - last[axis]);
            CHECK(steps == (cells == 0 ? 0 : 1));
            CHECK(at.at >= last_at);
            CHECK(at.at <= range);
            CHECK(state == State::free);
            for (std::size_t axis = 0; axis < 3; ++axis) last[axis] = at.cell[axis];
            last_at = at.at;
            ++cells;
            return false;
          }) == WalkEnd::at_range);
    double along = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      along += static_cast<double>(range) * std::abs(static_cast<double>(ray.direction[axis]));
    }
    CHECK(std::abs(cells - along) < 4.0);  // faces crossed, and the first cell
  }
}

TEST_CASE("a ray without direction or range finds nothing, one from outside leaves at once") {
  const FreeEverywhere everywhere;
  const auto cast = [&](BulkRay ray) { return cast_bulk_ray(ray, 0.05F, everywhere); };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(cast({{0, 0, 0}, {0, 0, 0}, 5.0F, 0}).end == RayEnd::max_range);
  CHECK(cast({{0, 0, 0}, {nan, 0, 1}, 5.0F, 0}).end == RayEnd::max_range);
  CHECK(cast({{0, 0, 0}, {1, 0, 0}, -1.0F, 0}).distance_m == -1.0F);
  CHECK(cast({{0, 0, 0}, {1, 0, 0}, nan, 0}).end == RayEnd::max_range);
  CHECK(cast({{nan, 0, 0}, {1, 0, 0}, 5.0F, 0}).end == RayEnd::left_grid);
  CHECK(cast({{1e6F, 0, 0}, {-1, 0, 0}, 5.0F, 0}).distance_m == 0.0F);
  const BulkHit out = cast({{0.01F, 0.01F, 0.01F}, {0, 0, -3}, 1e6F, 0});
  CHECK(out.end == RayEnd::left_grid);
  CHECK(out.voxel[2] == 0);
  CHECK(out.distance_m == Approx(0.01 + 32768 * 0.05));
}
