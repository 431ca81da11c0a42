// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/ray_grid.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "mapper/cpu/one_ray.hpp"

namespace g3d::mapper::cpu {
namespace {

constexpr int kTileRows_px = 16;

// Place (M & 511) of the voxel pair x = 2k, 2k + 1 within a row of eight: 0, 8, 64, 72; y adds 2, 16, 128; z 4, 32,
// 256.
constexpr std::array<std::uint16_t, 64> row_places() {
  std::array<std::uint16_t, 64> places{};
  for (std::int32_t z = 0; z < 8; ++z) {
    for (std::int32_t y = 0; y < 8; ++y) {
      places[8 * static_cast<std::size_t>(z) + static_cast<std::size_t>(y)] =
          static_cast<std::uint16_t>(encode({0, y, z}));
    }
  }
  return places;
}
constexpr std::array<std::uint16_t, 64> kRowPlace = row_places();
constexpr std::array<std::uint16_t, 4> kPairPlace{0, 8, 64, 72};

}  // namespace

RayGrid::RayGrid(const SensorGeometry& sensor, IntegratorKind kind)
    : kind_(kind), grid_(sensor.max_box_blocks() * kBlockVoxels + 64), column_slope_(sensor.column_slope) {
  column_slope_.resize(column_slope_.size() + kRayLanes, 0.0F);
}

void RayGrid::walk(const FrameWork& work, bool strong) {
  const hal::CameraModel& camera = work.sensor.camera;
  const auto& R = work.frame.rotation;
  RayRow constant{};
  constant.strong = strong;
  constant.metres_per_unit = work.sensor.metres_per_unit;
  constant.resolution_m = work.sensor.resolution_m;
  constant.origin[0] = work.frame.origin.x;
  constant.origin[1] = work.frame.origin.y;
  constant.origin[2] = work.frame.origin.z;
  constant.stride[0] = 1;
  constant.stride[1] = 8 * work.frame.nx_blocks;
  constant.stride[2] = constant.stride[1] * 8 * work.frame.ny_blocks;
  constant.grid = grid_.data();
  constant.spare_cell = static_cast<std::int32_t>(work.frame.block_count()) * kBlockVoxels;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constant.column[axis] = R[3 * axis];
    constant.translation[axis] = work.frame.translation_m[axis];
  }
  const auto walk_row = kind_ == IntegratorKind::dda ? work.kernels.walk_rays : work.kernels.walk_bresenham;
  const auto bands = static_cast<std::uint32_t>((camera.height_px + kTileRows_px - 1) / kTileRows_px);
  work.pool.parallel_for(bands, [&](std::uint32_t band) {
    RayRow row = constant;
    const int v0 = static_cast<int>(band) * kTileRows_px;
    // Tile by tile, so that the beam's voxels stay in the nearest cache.
    for (int u0 = 0; u0 < camera.width_px; u0 += kRayLanes) {
      row.lanes = std::min(kRayLanes, camera.width_px - u0);
      row.column_slope = column_slope_.data() + u0;
      for (int v = v0; v < std::min(v0 + kTileRows_px, camera.height_px); ++v) {
        const float slope = work.sensor.row_slope[static_cast<std::size_t>(v)];
        for (std::size_t axis = 0; axis < 3; ++axis) row.row_part[axis] = R[3 * axis + 1] * slope + R[3 * axis + 2];
        row.ends = work.ends.padded() + (v + kImagePadding) * work.ends.stride() + kImagePadding + u0;
        row.depth = work.ends.depth() + v * camera.width_px + u0;
        walk_row(row);
      }
    }
  });
}

bool RayGrid::read_out(const FrameGeometry& frame, const BlockView& block, FreeFlags& flags) {
  const std::size_t row_cells = 8U * static_cast<std::size_t>(frame.nx_blocks);
  const std::size_t slice_cells = row_cells * 8U * static_cast<std::size_t>(frame.ny_blocks);
  std::uint8_t* first = grid_.data() + 8U * static_cast<std::size_t>(block.bz) * slice_cells +
                        8U * static_cast<std::size_t>(block.by) * row_cells + 8U * static_cast<std::size_t>(block.bx);
  std::uint64_t any = 0;
  for (std::size_t z = 0; z < 8; ++z) {
    for (std::size_t y = 0; y < 8; ++y) {
      std::uint64_t eight;
      std::memcpy(&eight, first + z * slice_cells + y * row_cells, sizeof eight);
      any |= eight;
    }
  }
  if (any == 0) return false;
  for (std::size_t z = 0; z < 8; ++z) {
    for (std::size_t y = 0; y < 8; ++y) {
      std::uint8_t* row = first + z * slice_cells + y * row_cells;
      std::uint8_t* out = flags.data() + kRowPlace[8 * z + y];
      for (std::size_t pair = 0; pair < 4; ++pair) std::memcpy(out + kPairPlace[pair], row + 2 * pair, 2);
      std::memset(row, 0, 8);
    }
  }
  return true;
}

void RayGrid::offer(const FrameWork& work) {
  // Weak rays first: where a measured ray passes as well, its mark replaces theirs.
  if (work.ends.counts().invalid > 0) walk(work, false);
  walk(work, true);
  grid_[static_cast<std::size_t>(work.frame.block_count()) * kBlockVoxels] =
      0;  // the spare cell: the next box may reach it
  // A mark in a block that is thought hidden would turn up in a later frame.
  ExactBounds bounds;
  bounds.slack_m = walk_error_cells(work.sensor, work.frame) * work.sensor.resolution_m;
  const VisibleBlocks visible(work.sensor, work.frame, work.pyramid, work.kernels, 0.0F, 0.0F, bounds);
  const std::uint32_t chunks = visible.chunk_count();
  work.updater.begin(work.frame, work.with_colour, work.kernels, work.frame_number, chunks + 1,
                     visible.blocks_per_chunk(), work.pool.threads() == 1);
  const auto soon = [&](int bx, int by, int bz) { work.updater.prefetch_header(work.frame.block_key(bx, by, bz)); };
  const auto every = [](int, int, int) { return true; };  // even where nothing can change the marks must be wiped
  const auto known = [](int) { return false; };           // rays already say which marks are strong
  work.pool.parallel_for(chunks, [&](std::uint32_t chunk) {
    visible.for_chunk(chunk, soon, every, [&](const BlockView& block, BlockClass) {
      const BlockKey key = work.frame.block_key(block.bx, block.by, block.bz);
      HitRecord* hits = work.hits.find(work.frame.block_id(block.bx, block.by, block.bz));
      alignas(64) FreeFlags flags;
      if (read_out(work.frame, block, flags)) {
        work.updater.offer_some_free(chunk, key, flags, hits, known);
      } else if (hits != nullptr) {
        work.updater.offer_hits(chunk, key, *hits);
      }
    });
  });
}

}  // namespace g3d::mapper::cpu
