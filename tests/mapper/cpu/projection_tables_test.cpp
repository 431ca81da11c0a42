// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/projection_tables.hpp"

#include <catch2/catch.hpp>

#include "mapper/cpu/visible_blocks.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

TEST_CASE("tables hold each voxel's place behind the block's first one, scaled to pixels and raw units") {
  hal::CameraModel camera = test::small_camera(80);
  camera.fy_px *= 1.25F;
  camera.depth_units_per_metre = 5000.0F;
  const SensorGeometry sensor(camera, 0.04F, 0.8F, 3.5F);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto frame = frame_geometry(sensor, hal::to_transform(test::random_pose(seed)));
    REQUIRE(frame);
    ProjectionTables tables;
    fill_projection_tables(sensor, *frame, tables);
    const VoxelIndex first{frame->origin.x + 16, frame->origin.y + 8, frame->origin.z + 24};
    const auto p0 = voxel_in_camera_m(sensor, *frame, first);
    for (std::size_t place = 0; place < kBlockVoxels; ++place) {
      const VoxelIndex v = decode(place);
      const auto p = voxel_in_camera_m(sensor, *frame, {first.x + v.x, first.y + v.y, first.z + v.z});
      CHECK(tables.x_px_m[place] == Approx(camera.fx_px * (p[0] - p0[0])).margin(1e-3));
      CHECK(tables.y_px_m[place] == Approx(camera.fy_px * (p[1] - p0[1])).margin(1e-3));
      CHECK(tables.z_units[place] == Approx(5000.0F * (p[2] - p0[2])).margin(1e-2));
    }
    // Brick 5 holds the voxels 4..7, 0..3, 4..7.
    const auto low = voxel_in_camera_m(sensor, *frame, {first.x + 4, first.y, first.z + 4});
    const auto high = voxel_in_camera_m(sensor, *frame, {first.x + 7, first.y + 3, first.z + 7});
    CHECK(middle_of_brick(tables.z_units, 5 * 64) ==
          Approx(5000.0F * (0.5F * (low[2] + high[2]) - p0[2])).margin(1e-2));
  }
}
