// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/projective.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mapper/cpu/offer_visible.hpp"
#include "mapper/cpu/projection_tables.hpp"

namespace g3d::mapper::cpu {

float smallest_window_px(const SensorGeometry& sensor, const ProjectiveTuning& tuning) {
  const float far_m = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  return tuning.window_scale * sensor.camera.fx_px * sensor.resolution_m / far_m;
}

// Bricks of 4x4x4 voxels that begin farther than the camera trusts are hidden; the others are looked up by their
// middle.
float smallest_footprint_px(const SensorGeometry& sensor, const FrameGeometry& frame, const ProjectiveFrame& numbers) {
  const auto& R = frame.rotation;
  const float half_brick_m = 2.0F * sensor.resolution_m * (std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]));
  const float far_m = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  return numbers.window_px_m / (far_m + 1.01F * half_brick_m);
}

ProjectiveFrame projective_frame(const SensorGeometry& sensor, const FrameGeometry& frame,
                                 const ProjectiveTuning& tuning) {
  const auto& R = frame.rotation;
  const float shadow = std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]);
  ProjectiveFrame numbers;
  // A unit cube seen along n covers an area of |nx| + |ny| + |nz|, and rays run through it for one over that on
  // average.
  numbers.window_px_m = tuning.window_scale * sensor.camera.fx_px * sensor.resolution_m * std::sqrt(shadow);
  numbers.bias_m = tuning.bias_chords * sensor.resolution_m / shadow;
  numbers.bias_units = numbers.bias_m * sensor.camera.depth_units_per_metre;
  numbers.far_units = static_cast<float>(sensor.far_raw);
  numbers.far_bias_units = tuning.far_bias_chords * sensor.resolution_m / shadow * sensor.camera.depth_units_per_metre;
  const hal::CameraModel& camera = sensor.camera;
  numbers.left_px = -camera.cx_px;
  numbers.right_px = static_cast<float>(camera.width_px - 1) - camera.cx_px;
  numbers.top_px = -camera.cy_px;
  numbers.bottom_px = static_cast<float>(camera.height_px - 1) - camera.cy_px;
  // A plane through the camera and an image border has the normal (f, -border); the cube reaches across it by half the
  // sum of its edges' components along that normal.
  const float half_m = 0.5F * sensor.resolution_m;
  const auto reach = [&](std::size_t axis, float f, float border) {
    return half_m * (std::abs(f * R[axis] - border * R[2]) + std::abs(f * R[3 + axis] - border * R[5]) +
                     std::abs(f * R[6 + axis] - border * R[8]));
  };
  numbers.reach_px_m = {reach(0, camera.fx_px, numbers.left_px), reach(0, camera.fx_px, numbers.right_px),
                        reach(1, camera.fy_px, numbers.top_px), reach(1, camera.fy_px, numbers.bottom_px)};
  numbers.min_z_units = 0.5F * sensor.resolution_m * sensor.camera.depth_units_per_metre;
  return numbers;
}

Projective::Projective(const SensorGeometry& sensor, ProjectiveTuning tuning)
    : tuning_(tuning), images_(sensor.camera.width_px, sensor.camera.height_px, smallest_window_px(sensor, tuning)) {}

// Window of m cells centred on pixel coordinate u begins at cell floor((u + 1/2) / 2^L - m / 2 + 1/2), plus padding.
void Projective::fill_windows(const hal::CameraModel& camera) {
  for (int l = 0; l < images_.level_count(); ++l) {
    const FootprintLevel& level = images_.level(l);
    for (int m = 1; m <= kMaxWindow; ++m) {
      Window& w = windows_[static_cast<std::size_t>(l)][static_cast<std::size_t>(m)];
      w.choice = {l, m};
      w.cells_per_px = 1.0F / static_cast<float>(1 << l);
      const float begin = 0.5F - 0.5F * static_cast<float>(m) + static_cast<float>(kImagePadding);
      w.shift_x = (camera.cx_px + 0.5F) * w.cells_per_px + begin;
      w.shift_y = (camera.cy_px + 0.5F) * w.cells_per_px + begin;
      w.first_x = static_cast<float>(kImagePadding + 1 - m);
      w.first_y = w.first_x;
      w.last_x = static_cast<float>(level.width + kImagePadding - 1);
      w.last_y = static_cast<float>(level.height + kImagePadding - 1);
      w.stride = level.stride;
      w.image = images_.image(w.choice);
    }
  }
}

void Projective::fill_tables(const SensorGeometry& sensor, const FrameGeometry& frame) {
  fill_projection_tables(sensor, frame, tables_);
  for (std::size_t brick = 0; brick < kBricksPerBlock; ++brick) {
    middle_units_[brick] = middle_of_brick(tables_.z_units, brick * kBrickVoxels);
  }
}

bool Projective::look(const FrameWork& work, const ProjectiveFrame& numbers, const VisibleBlocks& visible,
                      const BlockView& block, const std::uint8_t* levels, FreeFlags& flags) const {
  const SensorGeometry& sensor = work.sensor;
  ProjectBrick brick{};
  brick.tables = &tables_;
  brick.x_px_m = sensor.camera.fx_px * block.x_m;
  brick.y_px_m = sensor.camera.fy_px * block.y_m;
  brick.z_units = sensor.camera.depth_units_per_metre * block.z_m;
  brick.metres_per_unit = sensor.metres_per_unit;
  brick.min_z_units = numbers.min_z_units;
  brick.bias_units = numbers.bias_units;
  brick.far_units = numbers.far_units;
  brick.far_bias_units = numbers.far_bias_units;
  brick.left_px = numbers.left_px;
  brick.right_px = numbers.right_px;
  brick.top_px = numbers.top_px;
  brick.bottom_px = numbers.bottom_px;
  std::copy(numbers.reach_px_m.begin(), numbers.reach_px_m.end(), brick.reach_px_m);
  bool any = false;
  const std::array<BlockClass, kBricksPerBlock> classes = visible.classify_bricks(block);
  static constexpr std::array<std::uint8_t, kBrickVoxels> kAllFree{};
  for (int first = 0; first < kBlockVoxels; first += kBrickVoxels) {
    if (levels != nullptr && std::memcmp(levels + first, kAllFree.data(), kBrickVoxels) == 0) {
      std::memset(flags.data() + first, 0, kBrickVoxels);
      continue;
    }
    const BlockClass found = classes[static_cast<std::size_t>(first / kBrickVoxels)];
    if (found == BlockClass::hidden || found == BlockClass::all_free) {
      std::memset(flags.data() + first, found == BlockClass::all_free ? kWeakFree : 0, kBrickVoxels);
      any |= found == BlockClass::all_free;
      continue;
    }
    const Window& w =
        window_at(sensor, numbers, brick.z_units + middle_units_[static_cast<std::size_t>(first / kBrickVoxels)]);
    brick.first_place = first;
    brick.at_border = found == BlockClass::look_at_border;
    brick.scale = w.cells_per_px;
    brick.shift_x = w.shift_x;
    brick.shift_y = w.shift_y;
    brick.first_x = w.first_x;
    brick.first_y = w.first_y;
    brick.last_x = w.last_x;
    brick.last_y = w.last_y;
    brick.stride = w.stride;
    brick.image = w.image;
    any |= work.kernels.project_brick(brick, flags.data());
  }
  return any;
}

bool Projective::is_strong(const FrameWork& work, const ProjectiveFrame& numbers, const BlockView& block,
                           int place) const {
  const SensorGeometry& sensor = work.sensor;
  const float block_units = sensor.camera.depth_units_per_metre * block.z_m;
  const Window& w =
      window_at(sensor, numbers, block_units + middle_units_[static_cast<std::size_t>(place / kBrickVoxels)]);
  const float z_units = block_units + tables_.z_units[place];
  if (z_units < numbers.min_z_units) return false;
  const float inverse = w.cells_per_px / (z_units * sensor.metres_per_unit);
  const float x = (sensor.camera.fx_px * block.x_m + tables_.x_px_m[place]) * inverse + w.shift_x;
  const float y = (sensor.camera.fy_px * block.y_m + tables_.y_px_m[place]) * inverse + w.shift_y;
  const int u0 = (static_cast<int>(std::min(std::max(x, w.first_x), w.last_x)) - kImagePadding) * (1 << w.choice.level);
  const int v0 = (static_cast<int>(std::min(std::max(y, w.first_y), w.last_y)) - kImagePadding) * (1 << w.choice.level);
  const int side = w.choice.window_cells << w.choice.level;
  const float beyond = z_units + numbers.bias_units;
  const bool far_counts = z_units + numbers.far_bias_units <= numbers.far_units;
  const float needed_units = far_counts ? std::min(beyond, numbers.far_units) : beyond;
  for (int v = std::max(v0, 0); v < std::min(v0 + side, sensor.camera.height_px); ++v) {
    for (int u = std::max(u0, 0); u < std::min(u0 + side, sensor.camera.width_px); ++u) {
      const float end_units = static_cast<float>(work.ends.at(u, v));
      if (end_units >= needed_units && work.ends.is_strong(u, v)) return true;
    }
  }
  return false;
}

void Projective::offer(const FrameWork& work) {
  const ProjectiveFrame numbers = projective_frame(work.sensor, work.frame, tuning_);
  images_.compute(work.ends, work.kernels, work.pool, smallest_footprint_px(work.sensor, work.frame, numbers));
  fill_windows(work.sensor.camera);
  fill_tables(work.sensor, work.frame);
  const VisibleBlocks visible(work.sensor, work.frame, work.pyramid, work.kernels, numbers.window_px_m, numbers.bias_m);
  offer_visible(
      work, visible,
      [&](const BlockView& block, const std::uint8_t* levels, const HitRecord*, FreeFlags& flags) {
        return look(work, numbers, visible, block, levels, flags);
      },
      [&](const BlockView& block, int place) { return is_strong(work, numbers, block, place); });
}

}  // namespace g3d::mapper::cpu
