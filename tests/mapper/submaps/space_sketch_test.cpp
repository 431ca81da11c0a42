// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/space_sketch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

hal::Frame wall_at(const hal::CameraModel& camera, std::uint16_t raw, hal::TimeNs stamp_ns) {
  hal::Frame frame = hal::make_frame(camera);
  std::fill_n(frame.depth.get(), camera.pixel_count(), raw);
  frame.stamp_ns = stamp_ns;
  return frame;
}

}  // namespace

TEST_CASE("a sketch says where its own frames saw free space and where a wall, and begins anew when it is taken") {
  for (const int width_px : {640, 320, 161, 80}) {
    const hal::CameraModel camera = test::small_camera(width_px);
    SpaceSketch sketch(camera);
    for (hal::TimeNs t = 0; t < 5; ++t) sketch.add(wall_at(camera, 2050, t * 200'000'000), {});
    const auto first = sketch.take();
    INFO(width_px << " px");
    CHECK(first->grid().resolution_m == 0.1F);
    CHECK(state_of(first->at(VoxelIndex{32768, 32768, 32768 + 10})) == State::free);
    CHECK(state_of(first->at(VoxelIndex{32768, 32768, 32768 + 20})) == State::occupied);
    CHECK(state_of(first->at(VoxelIndex{32768 + 4, 32768 - 3, 32768 + 20})) == State::occupied);
    CHECK(state_of(first->at(VoxelIndex{32768, 32768, 32768 + 24})) == State::unknown);
    CHECK(sketch.take()->counts().known() == 0);
    sketch.add(wall_at(camera, 1250, 2'000'000'000), {});
    const auto second = sketch.take();
    CHECK(state_of(second->at(VoxelIndex{32768, 32768, 32768 + 12})) == State::occupied);
    CHECK(state_of(second->at(VoxelIndex{32768, 32768, 32768 + 20})) == State::unknown);
  }
}

TEST_CASE("a sketch leaves frames out that come too soon after another") {
  const hal::CameraModel camera = test::small_camera(80);
  SpaceSketch sketch(camera);
  sketch.add(wall_at(camera, 2050, 1), {});
  sketch.add(wall_at(camera, 1250, 100'000'000), {});
  CHECK(state_of(sketch.take()->at(VoxelIndex{32768, 32768, 32768 + 12})) == State::free);
}
