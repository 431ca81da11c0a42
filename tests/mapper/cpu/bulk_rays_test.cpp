// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/bulk_rays.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "mapper/mapper.hpp"
#include "mapper/query.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

struct SlowGain {
  std::set<MCode> unknown;
  std::uint32_t blocked = 0;
  std::uint32_t near = 0;
};

/// Ends by cast_ray(), in double; before them by small steps, which find all but voxels whose corner a ray cuts off.
SlowGain slow_gain(const VoxelMap& map, const cpu::SensorGeometry& sensor, const Look& look, int stride_px) {
  SlowGain gain;
  const LookModel model = cpu::look_model(sensor, stride_px);
  const auto r = static_cast<double>(sensor.resolution_m);
  const std::array<double, 3> origin_m{look.position_m[0], look.position_m[1], look.position_m[2]};
  for (int v = 0; v < model.height_px; v += stride_px) {
    for (int u = 0; u < model.width_px; u += stride_px) {
      const std::array<double, 3> c{static_cast<double>(sensor.column_slope[static_cast<std::size_t>(u)]),
                                    static_cast<double>(sensor.row_slope[static_cast<std::size_t>(v)]), 1.0};
      const double length = std::sqrt(c[0] * c[0] + c[1] * c[1] + 1.0);
      std::array<double, 3> direction{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t j = 0; j < 3; ++j) direction[axis] += c[j] * static_cast<double>(look.rotation[3 * axis + j]);
      }
      const RayHit end = cast_ray(map, origin_m, direction, {static_cast<double>(model.far_m) * length, false});
      const double end_m = end.distance_m / length;
      const bool is_blocked = end.end == RayEnd::occupied;
      if (is_blocked && end_m <= static_cast<double>(model.near_m)) {
        ++gain.near;
        continue;
      }
      gain.blocked += is_blocked ? 1 : 0;
      for (double z = 0.0; z < end_m; z += 0.02 * r) {
        VoxelIndex voxel;
        voxel.x = 32767 + static_cast<std::int32_t>(std::ceil((origin_m[0] + z * direction[0]) / r));
        voxel.y = 32767 + static_cast<std::int32_t>(std::ceil((origin_m[1] + z * direction[1]) / r));
        voxel.z = 32767 + static_cast<std::int32_t>(std::ceil((origin_m[2] + z * direction[2]) / r));
        if (state_of(map.at(voxel)) == State::unknown) gain.unknown.insert(encode(voxel));
      }
    }
  }
  return gain;
}

}  // namespace

TEST_CASE("any number of threads casts the same rays and counts the same looks", "[threads]") {
  const auto map = tests::random_map(71, 400);
  const hal::CameraModel camera = test::small_camera(60);
  const cpu::SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  const std::vector<BulkRay> rays = test::random_rays(72, 3000, 0.05F, 2.0);
  std::vector<BulkHit> expected(rays.size());
  std::vector<Look> looks;
  for (std::uint64_t i = 0; i < 4; ++i)
    looks.push_back(cpu::look_from(sensor, hal::to_transform(test::random_pose(i))));
  std::vector<Look> expected_looks = looks;
  cpu::LookCounter counter(sensor);
  {
    cpu::ThreadPool pool(1);
    cpu::cast_bulk_rays(*map, rays, expected, pool);
    counter.count(*map, cpu::look_model(sensor, 1), expected_looks, pool);
  }
  cpu::ThreadPool pool(4);
  for (int times = 0; times < 3; ++times) {
    std::vector<BulkHit> hits(rays.size());
    cpu::cast_bulk_rays(*map, rays, hits, pool);
    CHECK(test::same_hits(hits, expected));
    std::vector<Look> again = looks;
    counter.count(*map, cpu::look_model(sensor, 1), again, pool);
    CHECK(std::memcmp(again.data(), expected_looks.data(), again.size() * sizeof(Look)) == 0);
  }
}

TEST_CASE("a look counts each unknown voxel once that its rays pass before they meet something") {
  const hal::CameraModel camera = test::small_camera(60);
  const cpu::SensorGeometry sensor(camera, 0.1F, 0.8F, 3.5F);
  const auto map = tests::furnished_room(0.1F);
  cpu::ThreadPool pool(1);
  cpu::LookCounter counter(sensor);
  std::uint32_t near = 0;
  std::uint32_t blocked = 0;
  tests::Random random(5);
  for (std::uint64_t i = 0; i < 6; ++i) {
    hal::Pose pose = test::random_pose(i);
    for (std::size_t axis = 0; axis < 2; ++axis) pose.translation_m[axis] = random.uniform(-1.8, 1.8);
    pose.translation_m[2] = random.uniform(0.3, 2.2);
    for (const int stride_px : {1, 3, 7}) {
      Look look = cpu::look_from(sensor, hal::to_transform(pose));
      counter.count(*map, cpu::look_model(sensor, stride_px), {&look, 1}, pool);
      const SlowGain slow = slow_gain(*map, sensor, look, stride_px);
      INFO("pose " << i << " stride " << stride_px);
      const auto found = static_cast<double>(slow.unknown.size());
      CHECK(look.gain.unknown_voxels >= 0.99 * found - 2);
      CHECK(look.gain.unknown_voxels <= 1.05 * found + 3);
      CHECK(std::abs(static_cast<int>(look.gain.blocked_rays) - static_cast<int>(slow.blocked)) <=
            1 + static_cast<int>(slow.blocked) / 50);
      CHECK(std::abs(static_cast<int>(look.gain.near_rays) - static_cast<int>(slow.near)) <=
            1 + static_cast<int>(slow.near) / 50);
      near += look.gain.near_rays;
      blocked += look.gain.blocked_rays;
    }
  }
  CHECK(near > 0);
  CHECK(blocked > 0);
}

TEST_CASE("a look from outside of the grid sees nothing") {
  const cpu::SensorGeometry sensor(test::small_camera(20), 0.05F, 0.8F, 3.5F);
  hal::Pose pose;
  pose.translation_m[0] = 1e5;
  Look look = cpu::look_from(sensor, hal::to_transform(pose));
  CHECK(look.blocks[0] == 0);
  const VoxelMap map(Grid{0.05F}, {16, 16, 16});
  cpu::ThreadPool pool(1);
  cpu::LookCounter(sensor).count(map, cpu::look_model(sensor, 1), {&look, 1}, pool);
  CHECK(look.gain.unknown_voxels == 0);
}

TEST_CASE("rays of a view go through its pixels, as far as the camera sees") {
  const hal::CameraModel camera = test::small_camera(40);
  const cpu::SensorGeometry sensor(camera, 0.05F, 0.8F, 3.5F);
  std::vector<BulkRay> rays(camera.pixel_count());
  const hal::Pose pose = test::random_pose(3);
  const hal::RigidTransform T = hal::to_transform(pose);
  CHECK(cpu::rays_from(sensor, T, 1, rays) == camera.pixel_count());
  CHECK(cpu::rays_from(sensor, T, 2, rays) == static_cast<std::size_t>(20 * ((camera.height_px + 1) / 2)));
  CHECK(cpu::rays_from(sensor, T, 1, std::span(rays).first(7)) == 7);
  CHECK(cpu::rays_from(sensor, T, 1, rays) == camera.pixel_count());
  const auto pixel = static_cast<std::size_t>(5 * camera.width_px + 9);
  const BulkRay& ray = rays[pixel];
  // Back into the camera.
  std::array<float, 3> in_camera{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t axis = 0; axis < 3; ++axis) in_camera[j] += T.rotation[3 * axis + j] * ray.direction[axis];
  }
  CHECK(in_camera[0] == Approx(sensor.column_slope[9]).margin(1e-5));
  CHECK(in_camera[1] == Approx(sensor.row_slope[5]).margin(1e-5));
  CHECK(in_camera[2] == Approx(1.0));
  CHECK(ray.origin_m[1] == T.translation_m[1]);
  CHECK(ray.max_range_m == Approx(3.5 * std::hypot(in_camera[0], in_camera[1], 1.0F)).epsilon(1e-4));
}
