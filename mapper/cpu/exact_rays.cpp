// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/exact_rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "mapper/cpu/offer_visible.hpp"
#include "mapper/cpu/one_ray.hpp"
#include "mapper/cpu/projection_tables.hpp"

namespace g3d::mapper::cpu {
namespace {

constexpr float kLeastMargin_cells = 0.01F;  // besides the walk's own rounding: that of the projections here
// Measured on the simulated drive: at 2 cm and 640 x 480 (3 px) 1.6 times as fast as walking, at 1 cm slower.
constexpr float kLeastVoxel_px = 2.5F;

/// Side of a voxel at the far bound, seen face on.
float smallest_voxel_px(const SensorGeometry& sensor) {
  const float far_m = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  return std::min(sensor.camera.fx_px, sensor.camera.fy_px) * sensor.resolution_m / far_m;
}

// A pixel's ray misses a point whose nearest pixel it is by at most half a pixel along both image axes; a voxel holds
// all that is nearer to its centre than half its side.
float sure_depth_m(const SensorGeometry& sensor, float margin_cells) {
  const float half_pixel = 0.5F * std::sqrt(1.0F / (sensor.camera.fx_px * sensor.camera.fx_px) +
                                            1.0F / (sensor.camera.fy_px * sensor.camera.fy_px));
  return (0.5F - margin_cells) * sensor.resolution_m / half_pixel;
}

}  // namespace

ExactRays::ExactRays(const SensorGeometry& sensor)
    : images_(sensor.camera.width_px, sensor.camera.height_px, std::floor(smallest_voxel_px(sensor)) + 1.0F),
      column_slope_(sensor.column_slope) {
  column_slope_.resize(column_slope_.size() + kRayLanes, 0.0F);
}

bool ExactRays::pays(const SensorGeometry& sensor) { return smallest_voxel_px(sensor) >= kLeastVoxel_px; }

void ExactRays::begin_frame(const FrameWork& work) {
  const SensorGeometry& sensor = work.sensor;
  const hal::CameraModel& camera = sensor.camera;
  const auto& R = work.frame.rotation;
  const float r = sensor.resolution_m;
  search_ = ray_search(sensor, work.frame, work.ends, column_slope_.data());
  fill_projection_tables(sensor, work.frame, tables_);
  const float margin_cells = std::max(kLeastMargin_cells, 2.0F * walk_error_cells(sensor, work.frame));
  bounds_ = {sure_depth_m(sensor, margin_cells), margin_cells * r};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    half_m_[axis] = (0.5F + margin_cells) * r * (std::abs(R[axis]) + std::abs(R[3 + axis]) + std::abs(R[6 + axis]));
  }
  flag_ = work.ends.counts().invalid == 0 ? kStrongFree : kWeakFree;

  SortBrick& b = common_;
  b.tables = &tables_;
  b.metres_per_unit = sensor.metres_per_unit;
  b.half_z_units = half_m_[2] * camera.depth_units_per_metre;
  b.sure_units = bounds_.sure_m * camera.depth_units_per_metre;
  b.middle_x = camera.cx_px + 0.5F + static_cast<float>(kImagePadding);
  b.middle_y = camera.cy_px + 0.5F + static_cast<float>(kImagePadding);
  b.first_px = static_cast<float>(kImagePadding);
  b.end_x = static_cast<float>(kImagePadding + camera.width_px);
  b.end_y = static_cast<float>(kImagePadding + camera.height_px);
  b.ends = work.ends.padded();
  b.ends_stride = work.ends.stride();
  b.left_px = -camera.cx_px;
  b.right_px = static_cast<float>(camera.width_px - 1) - camera.cx_px;
  b.top_px = -camera.cy_px;
  b.bottom_px = static_cast<float>(camera.height_px - 1) - camera.cy_px;
  // A plane through the camera and an image border has the normal (f, -border).
  const auto reach = [&](std::size_t axis, float f, float border) {
    return (0.5F + margin_cells) * r *
           (std::abs(f * R[axis] - border * R[2]) + std::abs(f * R[3 + axis] - border * R[5]) +
            std::abs(f * R[6 + axis] - border * R[8]));
  };
  b.reach_px_m[0] = reach(0, camera.fx_px, b.left_px);
  b.reach_px_m[1] = reach(0, camera.fx_px, b.right_px);
  b.reach_px_m[2] = reach(1, camera.fy_px, b.top_px);
  b.reach_px_m[3] = reach(1, camera.fy_px, b.bottom_px);
}

// The window must cover the silhouette of any voxel of the brick: a corner's pixel differs from the centre's by
// (f half_x + |u - cx| half_z) / (z - half_z) at most. Offsets within a brick reach 1.5 voxels from its middle.
void ExactRays::choose_window(const SensorGeometry& sensor, SortBrick& brick) const {
  const hal::CameraModel& camera = sensor.camera;
  const auto first = static_cast<std::size_t>(brick.first_place);
  brick.farthest = nullptr;
  const float z_m = (brick.z_units + middle_of_brick(tables_.z_units, first)) * sensor.metres_per_unit;
  const float nearest_m = z_m - 4.0F * half_m_[2];
  if (nearest_m < 2.0F * sensor.resolution_m) return;
  const auto around_px = [&](float middle_px_m, float f, float half_m) {
    const float off_axis_px = (std::abs(middle_px_m) + 3.0F * f * half_m) / nearest_m;
    return (f * half_m + off_axis_px * half_m_[2]) / nearest_m;
  };
  const float half_px =
      std::max(around_px(brick.x_px_m + middle_of_brick(tables_.x_px_m, first), camera.fx_px, half_m_[0]),
               around_px(brick.y_px_m + middle_of_brick(tables_.y_px_m, first), camera.fy_px, half_m_[1]));
  const auto choice = images_.covering(2.0F * half_px + 0.1F);
  if (!choice) return;
  const FootprintLevel& image = images_.level(choice->level);
  brick.scale = 1.0F / static_cast<float>(1 << choice->level);
  const float begin = 0.5F - 0.5F * static_cast<float>(choice->window_cells) + static_cast<float>(kImagePadding);
  brick.shift_x = (camera.cx_px + 0.5F) * brick.scale + begin;
  brick.shift_y = (camera.cy_px + 0.5F) * brick.scale + begin;
  brick.first_cell = static_cast<float>(kImagePadding + 1 - choice->window_cells);
  brick.last_x = static_cast<float>(image.width + kImagePadding - 1);
  brick.last_y = static_cast<float>(image.height + kImagePadding - 1);
  brick.farthest = images_.image(*choice);
  brick.farthest_stride = image.stride;
}

bool ExactRays::is_passed(const FrameWork& work, const BlockView& block, std::size_t place, bool strong) const {
  const VoxelIndex in_block = decode(place);
  const std::int32_t voxel[3] = {work.frame.origin.x + 8 * block.bx + in_block.x,
                                 work.frame.origin.y + 8 * block.by + in_block.y,
                                 work.frame.origin.z + 8 * block.bz + in_block.z};
  return work.kernels.find_ray(search_, voxel, strong);
}

bool ExactRays::look_at_brick(const FrameWork& work, const BlockView& block, const SortBrick& brick,
                              const std::uint8_t* levels, const HitRecord* hits, FreeFlags& flags) const {
  const auto first = static_cast<std::size_t>(brick.first_place);
  alignas(64) std::array<std::uint8_t, kBrickVoxels> sorted;
  if (!work.kernels.sort_brick(brick, sorted.data())) {
    std::memset(flags.data() + first, 0, kBrickVoxels);
    return false;
  }
  bool any = false;
  for (std::size_t i = 0; i < kBrickVoxels; ++i) {
    const std::size_t place = first + i;
    bool passed = sorted[i] == kPassed;
    if (sorted[i] == kOpen) {
      const bool matters = (hits == nullptr || hits->flags[place] == 0) && (levels == nullptr || levels[place] != 0);
      passed = matters && is_passed(work, block, place, false);
    }
    flags[place] = passed ? flag_ : 0;
    any |= passed;
  }
  return any;
}

bool ExactRays::look(const FrameWork& work, const VisibleBlocks& visible, const BlockView& block,
                     const std::uint8_t* levels, const HitRecord* hits, FreeFlags& flags) const {
  const SensorGeometry& sensor = work.sensor;
  SortBrick brick = common_;
  brick.x_px_m = sensor.camera.fx_px * block.x_m;
  brick.y_px_m = sensor.camera.fy_px * block.y_m;
  brick.z_units = sensor.camera.depth_units_per_metre * block.z_m;
  const std::array<BlockClass, kBricksPerBlock> classes = visible.classify_bricks(block);
  static constexpr std::array<std::uint8_t, kBrickVoxels> kAllFree{};
  bool any = false;
  for (std::size_t first = 0; first < kBlockVoxels; first += kBrickVoxels) {
    const BlockClass found = classes[first / kBrickVoxels];
    const bool settled = levels != nullptr && std::memcmp(levels + first, kAllFree.data(), kBrickVoxels) == 0;
    if (settled || found == BlockClass::hidden) {
      std::memset(flags.data() + first, 0, kBrickVoxels);
    } else if (found == BlockClass::all_free) {
      std::memset(flags.data() + first, flag_, kBrickVoxels);
      any = true;
    } else {
      brick.first_place = static_cast<int>(first);
      choose_window(sensor, brick);
      any |= look_at_brick(work, block, brick, levels, hits, flags);
    }
  }
  return any;
}

void ExactRays::offer(const FrameWork& work) {
  images_.compute(work.ends, work.kernels, work.pool);
  begin_frame(work);
  const VisibleBlocks visible(work.sensor, work.frame, work.pyramid, work.kernels, 0.0F, 0.0F, bounds_);
  offer_visible(
      work, visible,
      [&](const BlockView& block, const std::uint8_t* levels, const HitRecord* hits, FreeFlags& flags) {
        return look(work, visible, block, levels, hits, flags);
      },
      [&](const BlockView& block, int place) {
        return flag_ == kStrongFree || is_passed(work, block, static_cast<std::size_t>(place), true);
      });
}

}  // namespace g3d::mapper::cpu
