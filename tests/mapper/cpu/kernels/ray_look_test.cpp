// SPDX-License-Identifier: Apache-2.0
// What the kernels say of voxels, in every variant, against the plain walks of all rays.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "mapper/cpu/one_ray.hpp"
#include "mapper/cpu/projection_tables.hpp"
#include "mapper/cpu/visible_blocks.hpp"
#include "tests/support/kernel_variants.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

struct View {
  hal::CameraModel camera;
  SensorGeometry sensor;
  FrameGeometry frame;
  hal::Frame image;
  ThreadPool pool{1};
  RayEnds ends;
  std::vector<float> slopes;
  RaySearch search;
  test::PlainFree free;  ///< what all rays pass

  View(int width_px, float resolution_m, hal::Pose pose, std::uint64_t seed)
      : camera(test::small_camera(width_px)),
        sensor(camera, resolution_m, 0.8F, 3.5F),
        frame(frame_geometry(sensor, hal::to_transform(pose)).value()),
        image(test::random_frame(camera, seed)),
        ends(sensor, {}, 3000, true),
        slopes(sensor.column_slope) {
    slopes.resize(slopes.size() + kRayLanes, 0.0F);
    ends.compute(image.depth.get(), best_kernels(), pool);
    search = ray_search(sensor, frame, ends, slopes.data());
    const std::vector<std::uint16_t> mask(camera.pixel_count(), 3000);
    free = test::plain_free(sensor, frame, image.depth.get(),
                            test::plain_ray_ends(sensor, image.depth.get(), mask, true), IntegratorKind::dda);
  }
  [[nodiscard]] test::Seen seen(const VoxelIndex& k) const {
    const auto found = free.find(encode(k));
    return found == free.end() ? test::Seen::no : found->second;
  }
};

}  // namespace

TEST_CASE("a ray is found for every voxel that one passes and for no other", "[long]") {
  std::array<int, 3> count{};
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    hal::Pose pose = test::random_pose(seed);
    if (seed == 1) pose.translation_m = {0.5, -0.25, 1.0};
    const View view(seed < 2 ? 60 : 44, seed == 2 ? 0.125F : 0.2F, pose, seed);
    for (const Kernels* kernels : test::kernel_variants()) {
      int wrong = 0;
      for (int z = 0; z < 8 * view.frame.nz_blocks; ++z) {
        for (int y = 0; y < 8 * view.frame.ny_blocks; ++y) {
          for (int x = 0; x < 8 * view.frame.nx_blocks; ++x) {
            const VoxelIndex k{view.frame.origin.x + x, view.frame.origin.y + y, view.frame.origin.z + z};
            const std::int32_t voxel[3] = {k.x, k.y, k.z};
            const test::Seen seen = view.seen(k);
            ++count[static_cast<std::size_t>(seen)];
            wrong += kernels->find_ray(view.search, voxel, false) == (seen != test::Seen::no) ? 0 : 1;
            wrong += kernels->find_ray(view.search, voxel, true) == (seen == test::Seen::strong) ? 0 : 1;
          }
        }
      }
      INFO(kernels->name << " seed " << seed);
      CHECK(wrong == 0);
    }
  }
  CHECK(count[1] > 100);
  CHECK(count[2] > 5000);
}

TEST_CASE("what one pixel's end says of a brick's voxels is so") {
  for (std::uint64_t seed = 4; seed < 8; ++seed) {
    const View view(60, 0.125F, test::random_pose(seed), seed);
    const hal::CameraModel& camera = view.camera;
    const auto& R = view.frame.rotation;
    ProjectionTables tables;
    fill_projection_tables(view.sensor, view.frame, tables);
    const float r = view.sensor.resolution_m;
    SortBrick b{};
    b.tables = &tables;
    b.metres_per_unit = view.sensor.metres_per_unit;
    b.half_z_units = 1000.0F * 0.51F * r * (std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]));
    b.sure_units = 1000.0F * 0.49F * r / (std::sqrt(0.5F) / camera.fx_px);
    b.middle_x = camera.cx_px + 0.5F + static_cast<float>(kImagePadding);
    b.middle_y = camera.cy_px + 0.5F + static_cast<float>(kImagePadding);
    b.first_px = static_cast<float>(kImagePadding);
    b.end_x = static_cast<float>(kImagePadding + camera.width_px);
    b.end_y = static_cast<float>(kImagePadding + camera.height_px);
    b.ends = view.ends.padded();
    b.ends_stride = view.ends.stride();
    b.left_px = -camera.cx_px;
    b.right_px = static_cast<float>(camera.width_px - 1) - camera.cx_px;
    b.top_px = -camera.cy_px;
    b.bottom_px = static_cast<float>(camera.height_px - 1) - camera.cy_px;
    for (float& reach : b.reach_px_m) reach = 1.8F * r * camera.fx_px;  // more than any orientation's
    std::array<int, 3> count{};
    int wrong = 0;
    for (std::uint32_t id = 0; id < view.frame.block_count(); ++id) {
      const VoxelIndex first = decode(view.frame.block_key(id) << kBlockShift);
      const auto p = voxel_in_camera_m(view.sensor, view.frame, first);
      b.x_px_m = camera.fx_px * p[0];
      b.y_px_m = camera.fy_px * p[1];
      b.z_units = 1000.0F * p[2];
      for (int place = 0; place < kBlockVoxels; place += kBrickVoxels) {
        b.first_place = place;
        std::array<std::uint8_t, 64> expected{};
        for (const Kernels* kernels : test::kernel_variants()) {
          std::array<std::uint8_t, 64> sorted;
          bool any = false;
          const bool said = kernels->sort_brick(b, sorted.data());
          for (int i = 0; i < kBrickVoxels; ++i) {
            const VoxelIndex v = decode(static_cast<MCode>(place + i));
            const test::Seen seen = view.seen({first.x + v.x, first.y + v.y, first.z + v.z});
            const std::uint8_t answer = sorted[static_cast<std::size_t>(i)];
            any |= answer != 0;
            ++count[answer];
            if (answer == 0) wrong += seen == test::Seen::no ? 0 : 1;
            if (answer == kPassed) wrong += seen != test::Seen::no ? 0 : 1;
          }
          CHECK(said == any);
          if (kernels != test::kernel_variants().front()) CHECK(sorted == expected);
          expected = sorted;
        }
      }
    }
    INFO("seed " << seed);
    CHECK(wrong == 0);
    for (const int n : count) CHECK(n > 500);
  }
}
