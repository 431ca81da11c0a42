// SPDX-License-Identifier: Apache-2.0
// Many rays at once, in every variant, against one ray at a time; and the exact walk against geometry that knows
// nothing of walking: which voxels does a line cut?
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/morton.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

/// A frame's byte grid and the rays of one row, as RayGrid hands them to the kernels.
struct Beam {
  SensorGeometry sensor;
  FrameGeometry frame;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint16_t> ends;
  std::vector<float> slopes;
  int v;

  Beam(const hal::CameraModel& camera, float resolution_m, std::uint64_t seed)
      : sensor(camera, resolution_m, 0.8F, 3.5F),
        frame(frame_geometry(sensor, hal::to_transform(test::random_pose(seed))).value()),
        slopes(sensor.column_slope),
        v(static_cast<int>(seed) * 5 % camera.height_px) {
    slopes.resize(slopes.size() + kRayLanes, 0.0F);
    tests::Random random(seed);
    for (int u = 0; u < camera.width_px; ++u) {
      const bool blind = random.below(4) == 0;
      depth.push_back(blind ? std::uint16_t{0} : std::uint16_t{2000});
      ends.push_back(static_cast<std::uint16_t>(random.below(6) == 0 ? 0 : 1 + random.below(3500)));
    }
  }

  [[nodiscard]] std::size_t cell(const VoxelIndex& voxel) const {
    const int nx = 8 * frame.nx_blocks;
    const int ny = 8 * frame.ny_blocks;
    return static_cast<std::size_t>(voxel.x - frame.origin.x) +
           static_cast<std::size_t>(nx) *
               (static_cast<std::size_t>(voxel.y - frame.origin.y) +
                static_cast<std::size_t>(ny) * static_cast<std::size_t>(voxel.z - frame.origin.z));
  }

  void walk(void (*kernel)(const RayRow&), int u0, int lanes, bool strong, std::vector<std::uint8_t>& grid) const {
    RayRow row{};
    row.ends = ends.data() + u0;
    row.depth = depth.data() + u0;
    row.lanes = lanes;
    row.strong = strong;
    row.column_slope = slopes.data() + u0;
    row.metres_per_unit = sensor.metres_per_unit;
    row.resolution_m = sensor.resolution_m;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto& R = frame.rotation;
      row.column[a] = R[3 * a];
      row.row_part[a] = R[3 * a + 1] * sensor.row_slope[static_cast<std::size_t>(v)] + R[3 * a + 2];
      row.translation[a] = frame.translation_m[a];
    }
    row.origin[0] = frame.origin.x;
    row.origin[1] = frame.origin.y;
    row.origin[2] = frame.origin.z;
    row.stride[0] = 1;
    row.stride[1] = 8 * frame.nx_blocks;
    row.stride[2] = row.stride[1] * 8 * frame.ny_blocks;
    row.grid = grid.data();
    row.spare_cell = static_cast<std::int32_t>(frame.block_count()) * kBlockVoxels;
    kernel(row);
  }

  [[nodiscard]] std::vector<std::uint8_t> empty_grid() const {
    return std::vector<std::uint8_t>(static_cast<std::size_t>(frame.block_count()) * kBlockVoxels + 1, 0);
  }
};

/// Length of the part of a segment inside a voxel, in voxels; double precision. Negative: it misses it by that much.
double length_inside(const std::array<double, 3>& from, const std::array<double, 3>& to, const VoxelIndex& voxel) {
  const std::array<std::int32_t, 3> k{voxel.x, voxel.y, voxel.z};
  double in = 0;
  double out = 1;
  double length = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double span = to[a] - from[a];
    length += span * span;
    const double low = k[a] - 32768.0;
    if (span == 0) {
      if (from[a] <= low || from[a] > low + 1) return -1;
      continue;
    }
    const double t0 = (low - from[a]) / span;
    const double t1 = (low + 1 - from[a]) / span;
    in = std::max(in, std::min(t0, t1));
    out = std::min(out, std::max(t0, t1));
  }
  return (out - in) * std::sqrt(length);
}

}  // namespace

TEST_CASE("walked rays mark the cells of the plain walk, whatever the variant and the number of lanes") {
  for (const float resolution_m : {0.05F, 0.2F}) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const hal::CameraModel camera = test::small_camera(56);
      const Beam beam(camera, resolution_m, seed);
      for (const auto kind : {IntegratorKind::dda, IntegratorKind::bresenham}) {
        for (const bool strong : {true, false}) {
          auto expected = beam.empty_grid();
          for (int u = 0; u < camera.width_px; ++u) {
            const auto i = static_cast<std::size_t>(u);
            if (beam.ends[i] == 0 || (beam.depth[i] != 0) != strong) continue;
            for (const VoxelIndex& voxel : test::plain_ray(beam.sensor, beam.frame, u, beam.v, beam.ends[i], kind)) {
              expected[beam.cell(voxel)] = strong ? kStrongFree : kWeakFree;
            }
          }
          for (const Kernels* kernels : test::kernel_variants()) {
            auto found = beam.empty_grid();
            const auto kernel = kind == IntegratorKind::dda ? kernels->walk_rays : kernels->walk_bresenham;
            const int step = seed % 3 == 0 ? kRayLanes : seed % 3 == 1 ? 7 : 1;
            for (int u = 0; u < camera.width_px; u += step) {
              beam.walk(kernel, u, std::min(step, camera.width_px - u), strong, found);
            }
            found.back() = 0;  // idle lanes write there
            INFO(kernels->name << " " << to_string(kind) << " seed " << seed);
            REQUIRE(found == expected);
          }
        }
      }
    }
  }
}

TEST_CASE("the exact walk visits what a line cuts, but for corners that it only grazes") {
  const hal::CameraModel camera = test::small_camera(40);
  std::size_t visited = 0;
  std::size_t wrong = 0;
  std::size_t cut = 0;
  std::size_t missed = 0;
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
    const auto frame = frame_geometry(sensor, hal::to_transform(test::random_pose(seed)));
    REQUIRE(frame);
    for (int u = 1; u < camera.width_px; u += 7) {
      const int v = (u * 3) % camera.height_px;
      const std::uint16_t end_raw = static_cast<std::uint16_t>(900 + 61 * u);
      const auto passed = test::plain_ray(sensor, *frame, u, v, end_raw, IntegratorKind::dda);
      std::array<double, 3> from;
      std::array<double, 3> to;
      const double z = end_raw * static_cast<double>(sensor.metres_per_unit);
      const std::array<double, 3> slope{(u - double{camera.cx_px}) / double{camera.fx_px},
                                        (v - double{camera.cy_px}) / double{camera.fy_px}, 1};
      for (std::size_t a = 0; a < 3; ++a) {
        from[a] = double{frame->translation_m[a]} / double{sensor.resolution_m};
        to[a] = from[a];
        for (std::size_t b = 0; b < 3; ++b)
          to[a] += double{frame->rotation[3 * a + b]} * slope[b] * z / double{sensor.resolution_m};
      }
      std::set<MCode> seen;
      for (const VoxelIndex& voxel : passed) {
        seen.insert(encode(voxel));
        wrong += length_inside(from, to, voxel) < 0 ? 1 : 0;
      }
      visited += passed.size();
      // Every voxel around the ray that it cuts, except the last one, must have been visited.
      const auto index = [](double x) { return static_cast<std::int32_t>(std::ceil(x)) + kAxisOffset_cells; };
      const VoxelIndex last{index(to[0]), index(to[1]), index(to[2])};
      for (const VoxelIndex& voxel : passed) {
        for (int n = 0; n < 27; ++n) {
          const VoxelIndex near{voxel.x + n % 3 - 1, voxel.y + n / 3 % 3 - 1, voxel.z + n / 9 - 1};
          if (near == last || length_inside(from, to, near) <= 1e-3) continue;
          ++cut;
          missed += seen.contains(encode(near)) ? 0 : 1;
        }
      }
    }
  }
  CHECK(visited > 5000);
  CHECK(static_cast<double>(wrong) <= 0.001 * static_cast<double>(visited));
  CHECK(static_cast<double>(missed) <= 0.001 * static_cast<double>(cut));
}

TEST_CASE("a ray that stays in its voxel marks nothing, and one along an axis marks a straight line") {
  const hal::CameraModel camera = test::small_camera(40);
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  hal::RigidTransform T;
  T.translation_m = {0.025F, 0.025F, 0.025F};
  const auto frame = frame_geometry(sensor, T);
  REQUIRE(frame);
  for (const auto kind : {IntegratorKind::dda, IntegratorKind::bresenham}) {
    CHECK(test::plain_ray(sensor, *frame, 20, 15, 20, kind).empty());
    const auto line = test::plain_ray(sensor, *frame, 19, 15, 2000, kind);
    REQUIRE(line.size() >= 39);
    CHECK(line.front() == VoxelIndex{32768, 32768, 32768});
    for (std::size_t i = 1; i < line.size(); ++i) CHECK(line[i].z - line[i - 1].z <= 1);
  }
}
