// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/seen_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world_file.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/mapper.hpp"
#include "mapper/voxel_map.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::align;

TEST_CASE("space is clear where a voxel and all around it were seen free", "[mapper][align]") {
  VoxelMap map(Grid{0.05F}, {64, 64, 64});
  const SeenSpace space(map);
  const std::array<float, 3> point{0.215F, 0.215F, 0.215F};
  CHECK_FALSE(space.is_clear(point));  // nobody has looked
  const BlockKey key = block_of(map.grid().to_index(point[0], point[1], point[2]));
  BlockValues values;
  values.fill(Rgbo{kUnknownLevel - 4});
  REQUIRE(map.write_block(key, values));
  CHECK(space.is_clear(point));
  CHECK_FALSE(space.is_clear({0.015F, 0.215F, 0.215F}));  // beside it nobody has looked
  const VoxelIndex at = map.grid().to_index(point[0], point[1], point[2]);
  for (const int beside : {0, 1, 2}) {
    CAPTURE(beside);
    BlockValues one = values;
    one[static_cast<std::size_t>(encode({at.x + beside, at.y, at.z}) & kPlaceMask)] = Rgbo{kUnknownLevel + 4};
    REQUIRE(map.write_block(key, one));
    CHECK(space.is_clear(point) == (beside == 2));
  }
  CHECK_FALSE(space.is_clear({3e4F, 0.0F, 0.0F}));
}

namespace {

/// A robot stands in a room; somebody as wide as a cupboard comes towards it slowly, then goes away again. How far it
/// is taken along at most.
double taken_along_m(bool looks_at_map) {
  const hal::CameraModel camera = hal::scaled_kinect(160, 120);
  const hal::Pose T_world_camera = hal::forward_camera(0.5);
  MapperConfig config;
  Mapper mapper(config, camera, {});
  Aligner aligner({}, camera);
  hal::Frame frame = hal::make_frame(camera);
  double most_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    const double x_m = i < 20 ? 3.1 : i < 60 ? 3.1 - 0.035 * (i - 20) : 1.7 + 0.035 * (i - 60);
    auto world = hal::parse_world(fmt::format("room 0 0 0 8 6 2.5 0.1\nbox {} 0 0 0.3 1.6 1.8\n", x_m), "test.world");
    hal::SimRenderer renderer(std::move(world).value(), {.camera = camera});
    renderer.render(T_world_camera, i * 100'000'000LL, static_cast<std::uint64_t>(i), frame);
    frame.stamp_ns = i * 100'000'000LL;
    const SeenSpace space(mapper.map());
    const AlignResult result = aligner.align(frame, T_world_camera, looks_at_map ? &space : nullptr);
    (void)mapper.integrate(frame, result.T_world_camera);
    most_m = std::max(most_m, std::abs(result.T_world_camera.translation_m[0]));
  }
  CHECK((aligner.surfaces().unsteady_count() > 0) == looks_at_map);
  return most_m;
}

}  // namespace

TEST_CASE("who comes out of free space takes nobody along", "[mapper][align][slow]") {
  const double without_m = taken_along_m(false);
  const double with_m = taken_along_m(true);
  CAPTURE(without_m, with_m);
  CHECK(with_m < 0.04);
  CHECK(with_m < 0.5 * without_m);
}
