// SPDX-License-Identifier: Apache-2.0
// What is said of a block must hold for every voxel in it, as the plain projective test and the plain rays see them.
#include "mapper/cpu/visible_blocks.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "mapper/cpu/projective.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::cpu;

namespace {

struct View {
  hal::CameraModel camera = test::small_camera(60);
  SensorGeometry sensor;
  FrameGeometry frame;
  hal::Frame image;
  ThreadPool pool{1};
  RayEnds ends;
  DepthPyramid pyramid;

  View(float resolution_m, std::uint64_t seed)
      : sensor(camera, resolution_m, 0.8F, 3.5F),
        frame(frame_geometry(sensor, hal::to_transform(test::random_pose(seed))).value()),
        image(test::random_frame(camera, seed)),
        ends(sensor, {}, 3000, true),
        pyramid(camera.width_px, camera.height_px) {
    if (seed % 5 == 0) std::fill_n(image.depth.get(), camera.pixel_count(), std::uint16_t{3200});  // a bare wall
    ends.compute(image.depth.get(), best_kernels(), pool);
    pyramid.compute(ends, best_kernels(), pool);
  }

  /// Which voxels are free, by block.
  [[nodiscard]] std::map<BlockKey, std::array<bool, 512>> free_voxels(IntegratorKind kind) const {
    const std::vector<std::uint16_t> mask(camera.pixel_count(), 3000);
    const auto plain_ends = test::plain_ray_ends(sensor, image.depth.get(), mask, true);
    std::map<BlockKey, std::array<bool, 512>> blocks;
    for (const auto& [code, seen] : test::plain_free(sensor, frame, image.depth.get(), plain_ends, kind)) {
      blocks[code >> kBlockShift][code & kPlaceMask] = true;
    }
    return blocks;
  }
};

struct Visit {
  BlockView view;
  BlockClass found;
};

/// All blocks that are not hidden.
std::map<std::uint32_t, Visit> classes_of(const VisibleBlocks& visible, const FrameGeometry& frame) {
  std::map<std::uint32_t, Visit> classes;
  for (std::uint32_t chunk = 0; chunk < visible.chunk_count(); ++chunk) {
    visible.for_chunk(
        chunk, [](int, int, int) {}, [](int, int, int) { return true; },
        [&](const BlockView& block, BlockClass found) {
          classes[frame.block_id(block.bx, block.by, block.bz)] = {block, found};
        });
  }
  return classes;
}

}  // namespace

TEST_CASE("no voxel of a hidden block or brick is free, every voxel of an all-free one is") {
  std::array<int, 4> blocks{};
  std::array<int, 4> bricks{};
  for (const float resolution_m : {0.04F, 0.1F}) {
    for (std::uint64_t seed = 0; seed < (resolution_m < 0.05F ? 2U : 10U); ++seed) {
      const View view(resolution_m, seed);
      const ProjectiveFrame numbers = projective_frame(view.sensor, view.frame, {});
      const VisibleBlocks visible(view.sensor, view.frame, view.pyramid, best_kernels(), numbers.window_px_m,
                                  numbers.bias_m);
      const auto free = view.free_voxels(IntegratorKind::projective);
      const auto classes = classes_of(visible, view.frame);
      int wrong = 0;
      for (std::uint32_t id = 0; id < view.frame.block_count(); ++id) {
        const auto flags = free.find(view.frame.block_key(id));
        const auto free_in = [&](std::size_t from, std::size_t count) {
          return flags == free.end()
                     ? 0
                     : static_cast<int>(std::count(&flags->second[from], &flags->second[from] + count, true));
        };
        const auto visit = classes.find(id);
        const BlockClass found = visit == classes.end() ? BlockClass::hidden : visit->second.found;
        ++blocks[static_cast<std::size_t>(found)];
        if (found == BlockClass::hidden) wrong += free_in(0, 512) != 0 ? 1 : 0;
        if (found == BlockClass::all_free) wrong += free_in(0, 512) != 512 ? 1 : 0;
        if (visit == classes.end()) continue;
        const auto of_bricks = visible.classify_bricks(visit->second.view);
        for (std::size_t b = 0; b < 8; ++b) {
          ++bricks[static_cast<std::size_t>(of_bricks[b])];
          if (of_bricks[b] == BlockClass::hidden) wrong += free_in(64 * b, 64) != 0 ? 1 : 0;
          if (of_bricks[b] == BlockClass::all_free) wrong += free_in(64 * b, 64) != 64 ? 1 : 0;
        }
      }
      INFO(resolution_m << " m, seed " << seed);
      REQUIRE(wrong == 0);
    }
  }
  for (const int count : blocks) CHECK(count > 20);  // each answer is given often enough to be worth something
  for (const int count : bricks) CHECK(count > 20);
}

TEST_CASE("rays pass all voxels of blocks and bricks that are all free, and none of hidden ones, within exact bounds") {
  std::array<int, 4> blocks{};
  std::array<int, 4> bricks{};
  for (std::uint64_t seed = 30; seed < 38; ++seed) {
    const View view(0.1F, seed);
    ExactBounds bounds;
    bounds.sure_m = 0.49F * 0.1F * view.camera.fx_px / std::sqrt(0.5F);
    bounds.slack_m = 0.01F * 0.1F;
    const VisibleBlocks visible(view.sensor, view.frame, view.pyramid, best_kernels(), 0.0F, 0.0F, bounds);
    const auto free = view.free_voxels(IntegratorKind::dda);
    const auto classes = classes_of(visible, view.frame);
    int wrong = 0;
    const auto judge = [&](BlockClass found, const std::array<bool, 512>& flags, std::size_t from, std::size_t count) {
      const auto passed = static_cast<std::size_t>(std::count(&flags[from], &flags[from] + count, true));
      if (found == BlockClass::hidden) wrong += passed != 0 ? 1 : 0;
      if (found == BlockClass::all_free) wrong += passed != count ? 1 : 0;
    };
    for (std::uint32_t id = 0; id < view.frame.block_count(); ++id) {
      const auto known = free.find(view.frame.block_key(id));
      const std::array<bool, 512> flags = known == free.end() ? std::array<bool, 512>{} : known->second;
      const auto visit = classes.find(id);
      const BlockClass found = visit == classes.end() ? BlockClass::hidden : visit->second.found;
      ++blocks[static_cast<std::size_t>(found)];
      judge(found, flags, 0, 512);
      if (visit == classes.end()) continue;
      const auto of_bricks = visible.classify_bricks(visit->second.view);
      for (std::size_t b = 0; b < 8; ++b) {
        ++bricks[static_cast<std::size_t>(of_bricks[b])];
        judge(of_bricks[b], flags, 64 * b, 64);
      }
    }
    INFO("seed " << seed);
    REQUIRE(wrong == 0);
  }
  CHECK(blocks[static_cast<std::size_t>(BlockClass::hidden)] > 20);
  for (const int count : bricks) CHECK(count > 20);
}

TEST_CASE("no exact ray passes through a hidden block") {
  for (std::uint64_t seed = 20; seed < 26; ++seed) {
    const View view(0.06F, seed);
    const VisibleBlocks visible(view.sensor, view.frame, view.pyramid, best_kernels(), 0.0F, 0.0F);
    const auto classes = classes_of(visible, view.frame);
    const auto passed = view.free_voxels(IntegratorKind::dda);
    std::size_t seen = 0;
    for (std::uint32_t id = 0; id < view.frame.block_count(); ++id) {
      if (!passed.contains(view.frame.block_key(id))) continue;
      ++seen;
      REQUIRE(classes.contains(id));
    }
    CHECK(seen == passed.size());  // and none passes outside of the box
  }
}

TEST_CASE("the chunks visit no block twice, and none that nobody wants") {
  const View view(0.05F, 5);
  const VisibleBlocks visible(view.sensor, view.frame, view.pyramid, best_kernels(), 10.0F, 0.01F);
  std::set<std::uint32_t> visited;
  std::set<std::uint32_t> odd;
  for (std::uint32_t chunk = 0; chunk < visible.chunk_count(); ++chunk) {
    std::uint32_t in_chunk = 0;
    visible.for_chunk(
        chunk, [](int, int, int) {}, [](int, int, int) { return true; },
        [&](const BlockView& block, BlockClass found) {
          ++in_chunk;
          CHECK(found != BlockClass::hidden);
          CHECK(visited.insert(view.frame.block_id(block.bx, block.by, block.bz)).second);
        });
    CHECK(in_chunk <= visible.blocks_per_chunk());
    std::set<std::uint32_t> announced;
    visible.for_chunk(
        chunk, [&](int bx, int by, int bz) { announced.insert(view.frame.block_id(bx, by, bz)); },
        [&](int bx, int by, int bz) {
          CHECK(announced.count(view.frame.block_id(bx, by, bz)) == 1);
          return bx % 2 == 1;
        },
        [&](const BlockView& block, BlockClass) { odd.insert(view.frame.block_id(block.bx, block.by, block.bz)); });
  }
  CHECK(visited.size() > 100);
  std::set<std::uint32_t> expected;
  for (const std::uint32_t id : visited) {
    if (static_cast<int>(id) % view.frame.nx_blocks % 2 == 1) expected.insert(id);
  }
  CHECK(odd == expected);
}

TEST_CASE("a voxel's camera coordinates are those of its centre") {
  const SensorGeometry sensor(test::small_camera(40), 0.05F, 0.8F, 3.5F);
  const Grid grid{0.05F};
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const hal::RigidTransform T = hal::to_transform(test::random_pose(seed));
    const auto frame = frame_geometry(sensor, T);
    REQUIRE(frame);
    const VoxelIndex voxel{frame->origin.x + 31, frame->origin.y + 17, frame->origin.z + 5};
    const auto c = grid.centre_m(voxel);
    const auto p = voxel_in_camera_m(sensor, *frame, voxel);
    for (std::size_t a = 0; a < 3; ++a) {  // and back into the world
      double back = double{T.translation_m[a]};
      for (std::size_t b = 0; b < 3; ++b) back += double{T.rotation[3 * a + b]} * double{p[b]};
      CHECK(back == Approx(c[a]).margin(1e-4));
    }
  }
}
