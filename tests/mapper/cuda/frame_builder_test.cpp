// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/frame_builder.hpp"

#include <catch2/catch.hpp>

#include "mapper/cpu/footprint_images.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cuda;

TEST_CASE("frame parameters describe the CPU twin's box, images and modes") {
  for (const int width : {20, 60, 100, 640}) {
    const hal::CameraModel camera = test::small_camera(width);
    MapperConfig config;
    const cpu::SensorGeometry sensor(camera, config.resolution_m, config.near_m, config.far_m);
    const FrameBuilder builder(config, sensor, {});
    const auto frame = cpu::frame_geometry(sensor, hal::to_transform(test::random_pose(1)));
    REQUIRE(frame);
    FrameInput input;
    builder.fill(*frame, true, 7, input);
    const FrameParams& params = input.params;
    CHECK(params.frame_number == 7);
    CHECK(params.free_by == FreeBy::projection);
    CHECK(params.blocks[0] * params.blocks[1] * params.blocks[2] == static_cast<int>(frame->block_count()));
    const cpu::FootprintImages images(camera.width_px, camera.height_px, 1.0F);
    REQUIRE(params.image_levels == images.level_count());
    for (int l = 0; l < params.image_levels; ++l) {
      CHECK(params.shapes[l].width == images.level(l).width);
      CHECK(params.shapes[l].height == images.level(l).height);
      CHECK(params.shapes[l].stride == images.level(l).stride);
      CHECK(params.shapes[l].rows == images.level(l).rows);
    }
  }
}

TEST_CASE("only rays need marks, and a static map needs no free space") {
  const hal::CameraModel camera = test::small_camera(60);
  MapperConfig config;
  const cpu::SensorGeometry sensor(camera, config.resolution_m, config.near_m, config.far_m);
  const auto frame = cpu::frame_geometry(sensor, {});
  FrameInput input;
  const FrameParams& params = input.params;
  const auto fill = [&] {
    const FrameBuilder builder(config, sensor, {});
    builder.fill(*frame, false, 1, input);
    return builder.sizes().walks_rays;
  };
  CHECK(fill() == 0);
  config.integrator = IntegratorKind::dda;
  CHECK(fill() == 1);
  CHECK(params.free_by == FreeBy::exact_rays);
  config.integrator = IntegratorKind::bresenham;
  CHECK(fill() == 1);
  CHECK(params.free_by == FreeBy::thesis_rays);
  config.mode = MapMode::static_mode;
  CHECK(fill() == 0);
  CHECK(params.free_by == FreeBy::nothing);
}

TEST_CASE("a recorded scan mask is cut at the certainty bound, and there is one without a recording") {
  const hal::CameraModel camera = test::small_camera(20);
  MapperConfig config;
  const cpu::SensorGeometry sensor(camera, config.resolution_m, config.near_m, config.far_m);
  CHECK(FrameBuilder(config, sensor, {}).mask().at(5) == 3000);
  std::vector<std::uint16_t> recorded(camera.pixel_count(), 1234);
  recorded[5] = 60000;
  const FrameBuilder builder(config, sensor, recorded);
  CHECK(builder.mask()[4] == 1234);
  CHECK(builder.mask()[5] == sensor.far_raw);
}
