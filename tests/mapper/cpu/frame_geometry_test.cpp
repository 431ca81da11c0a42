// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/frame_geometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

TEST_CASE("bounds become raw readings, slopes are those of the pinhole") {
  hal::CameraModel camera = test::small_camera(80);
  camera.depth_units_per_metre = 5000.0F;
  const SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  CHECK(sensor.near_raw == 4000);
  CHECK(sensor.far_raw == 17500);
  CHECK(sensor.metres_per_unit == Approx(0.0002));
  REQUIRE(sensor.column_slope.size() == 80);
  REQUIRE(sensor.row_slope.size() == 60);
  CHECK(sensor.column_slope[79] == Approx((79 - camera.cx_px) / camera.fx_px));
  CHECK(sensor.row_slope[0] == Approx(-camera.cy_px / camera.fy_px));
  CHECK(SensorGeometry(camera, 0.05F, 0.0F, 100.0F).near_raw == 1);  // 0 would be "no reading"
  CHECK(SensorGeometry(camera, 0.05F, 0.0F, 100.0F).far_raw == 65535);
}

TEST_CASE("the box holds every ray up to the far bound, whatever the pose, and is never larger than reserved") {
  const hal::CameraModel camera = test::small_camera(40);
  for (const float resolution_m : {0.02F, 0.05F, 0.2F}) {
    const SensorGeometry sensor(camera, resolution_m, 0.8F, 3.5F);
    const Grid grid{resolution_m};
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      const hal::RigidTransform T = hal::to_transform(test::random_pose(seed));
      const auto frame = frame_geometry(sensor, T);
      REQUIRE(frame);
      REQUIRE(std::max({frame->nx_blocks, frame->ny_blocks, frame->nz_blocks}) <= sensor.max_side_blocks);
      REQUIRE(frame->block_count() <= sensor.max_box_blocks());
      REQUIRE((frame->origin.x % 8 == 0 && frame->origin.y % 8 == 0 && frame->origin.z % 8 == 0));
      int outside = 0;
      for (int v = 0; v < camera.height_px; v += 3) {
        for (int u = 0; u < camera.width_px; u += 3) {
          for (const float z : {0.0F, 0.8F, 2.0F, 3.5F}) {
            const float x_m = (static_cast<float>(u) - camera.cx_px) / camera.fx_px * z;
            const float y_m = (static_cast<float>(v) - camera.cy_px) / camera.fy_px * z;
            std::array<std::int32_t, 3> k;
            for (std::size_t a = 0; a < 3; ++a) {
              k[a] = grid.to_index(T.rotation[3 * a] * x_m + T.rotation[3 * a + 1] * y_m + T.rotation[3 * a + 2] * z +
                                   T.translation_m[a]);
            }
            const bool inside = k[0] >= frame->origin.x && k[0] < frame->origin.x + 8 * frame->nx_blocks &&
                                k[1] >= frame->origin.y && k[1] < frame->origin.y + 8 * frame->ny_blocks &&
                                k[2] >= frame->origin.z && k[2] < frame->origin.z + 8 * frame->nz_blocks;
            outside += inside ? 0 : 1;
          }
        }
      }
      REQUIRE(outside == 0);
    }
  }
}

TEST_CASE("block names go there and back") {
  const SensorGeometry sensor(test::small_camera(40), 0.1F, 0.8F, 3.5F);
  const auto frame = frame_geometry(sensor, hal::to_transform(test::random_pose(3)));
  REQUIRE(frame);
  std::uint32_t id = 0;
  for (int z = 0; z < frame->nz_blocks; ++z) {
    for (int y = 0; y < frame->ny_blocks; ++y) {
      for (int x = 0; x < frame->nx_blocks; ++x, ++id) {
        REQUIRE(frame->block_id(x, y, z) == id);
        const BlockKey key = block_of({frame->origin.x + 8 * x, frame->origin.y + 8 * y, frame->origin.z + 8 * z});
        REQUIRE(frame->block_key(x, y, z) == key);
        REQUIRE(frame->block_key(id) == key);
      }
    }
  }
  CHECK(frame->block_count() == id);
}

TEST_CASE("a pose near or beyond the end of the 16-bit grid has no box, and neither has nonsense") {
  const SensorGeometry sensor(test::small_camera(40), 0.05F, 0.8F, 3.5F);
  hal::RigidTransform T;
  CHECK(frame_geometry(sensor, T));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float x_m : {1.0F, -1.0F}) {
      T.translation_m = {0, 0, 0};
      T.translation_m[axis] = x_m * 1620.0F;
      CHECK(frame_geometry(sensor, T));
      for (const float far_m : {1638.0F, 1700.0F, 1e9F, 1e30F, std::numeric_limits<float>::infinity()}) {
        T.translation_m[axis] = x_m * far_m;
        CHECK_FALSE(frame_geometry(sensor, T));
      }
    }
  }
  T.translation_m = {std::nanf(""), 0, 0};
  CHECK_FALSE(frame_geometry(sensor, T));
}
