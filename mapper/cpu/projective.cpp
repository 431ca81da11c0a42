// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/projective.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::mapper::cpu {
namespace {

float smallest_window_px(const SensorGeometry& sensor, const ProjectiveTuning& tuning) {
  const float far_m = static_cast<float>(sensor.far_raw) * sensor.metres_per_unit;
  return tuning.window_scale * sensor.camera.fx_px * sensor.resolution_m / far_m;
}

struct Window {
  FootprintImages::Choice choice;
  float cells_per_px;
  float shift_x;
  float shift_y;
  float last_x;
  float last_y;
};

// Window of m cells centred on pixel coordinate u begins at cell floor((u + 1/2) / 2^L - m / 2 + 1/2), plus padding.
Window window_for(const FootprintImages& images, const hal::CameraModel& camera, float size_px) {
  Window w;
  w.choice = images.choose(size_px);
  const FootprintLevel& level = images.level(w.choice.level);
  w.cells_per_px = 1.0F / static_cast<float>(1 << w.choice.level);
  const float begin = 0.5F - 0.5F * static_cast<float>(w.choice.window_cells) + static_cast<float>(kImagePadding);
  w.shift_x = (camera.cx_px + 0.5F) * w.cells_per_px + begin;
  w.shift_y = (camera.cy_px + 0.5F) * w.cells_per_px + begin;
  w.last_x = static_cast<float>(level.width + kImagePadding);
  w.last_y = static_cast<float>(level.height + kImagePadding);
  return w;
}

}  // namespace

ProjectiveFrame projective_frame(const SensorGeometry& sensor, const FrameGeometry& frame, const ProjectiveTuning& tuning) {
  const auto& R = frame.rotation;
  const float depth_extent = std::abs(R[2]) + std::abs(R[5]) + std::abs(R[8]);
  ProjectiveFrame numbers;
  numbers.window_px_m = tuning.window_scale * sensor.camera.fx_px * sensor.resolution_m;
  numbers.bias_m = tuning.bias_voxels * sensor.resolution_m * depth_extent;
  numbers.bias_units = numbers.bias_m * sensor.camera.depth_units_per_metre;
  numbers.min_z_units = 0.5F * sensor.resolution_m * sensor.camera.depth_units_per_metre;
  return numbers;
}

Projective::Projective(const SensorGeometry& sensor, ProjectiveTuning tuning)
    : tuning_(tuning),
      images_(sensor.camera.width_px, sensor.camera.height_px, smallest_window_px(sensor, tuning)) {}

void Projective::fill_tables(const SensorGeometry& sensor, const FrameGeometry& frame) {
  const auto& R = frame.rotation;
  const float r = sensor.resolution_m;
  for (std::size_t place = 0; place < kBlockVoxels; ++place) {
    const VoxelIndex v = decode(place);
    const float x = static_cast<float>(v.x) * r;
    const float y = static_cast<float>(v.y) * r;
    const float z = static_cast<float>(v.z) * r;
    tables_.x_px_m[place] = sensor.camera.fx_px * (R[0] * x + R[3] * y + R[6] * z);
    tables_.y_px_m[place] = sensor.camera.fy_px * (R[1] * x + R[4] * y + R[7] * z);
    tables_.z_units[place] = sensor.camera.depth_units_per_metre * (R[2] * x + R[5] * y + R[8] * z);
  }
}

bool Projective::look(const FrameWork& work, const ProjectiveFrame& numbers, const BlockView& block, FreeFlags& flags) const {
  const SensorGeometry& sensor = work.sensor;
  ProjectBrick brick{};
  brick.tables = &tables_;
  brick.x_px_m = sensor.camera.fx_px * block.x_m;
  brick.y_px_m = sensor.camera.fy_px * block.y_m;
  brick.z_units = sensor.camera.depth_units_per_metre * block.z_m;
  brick.metres_per_unit = sensor.metres_per_unit;
  brick.min_z_units = numbers.min_z_units;
  brick.bias_units = numbers.bias_units;
  bool any = false;
  for (int first = 0; first < kBlockVoxels; first += kBrickVoxels) {
    // The middle of a brick of 4x4x4 voxels lies half way between its first voxel and its last.
    const float middle_units = brick.z_units + 0.5F * (tables_.z_units[first] + tables_.z_units[first + kBrickVoxels - 1]);
    const float middle_m = std::max(middle_units, numbers.min_z_units) * sensor.metres_per_unit;
    const Window w = window_for(images_, sensor.camera, numbers.window_px_m / middle_m);
    brick.first_place = first;
    brick.scale = w.cells_per_px;
    brick.shift_x = w.shift_x;
    brick.shift_y = w.shift_y;
    brick.last_x = w.last_x;
    brick.last_y = w.last_y;
    brick.stride = images_.level(w.choice.level).stride;
    brick.image = images_.image(w.choice);
    any |= work.kernels.project_brick(brick, flags.data());
  }
  return any;
}

bool Projective::is_strong(const FrameWork& work, const ProjectiveFrame& numbers, const BlockView& block, int place) const {
  const SensorGeometry& sensor = work.sensor;
  const int first = place & ~(kBrickVoxels - 1);
  const float block_units = sensor.camera.depth_units_per_metre * block.z_m;
  const float middle_units = block_units + 0.5F * (tables_.z_units[first] + tables_.z_units[first + kBrickVoxels - 1]);
  const float middle_m = std::max(middle_units, numbers.min_z_units) * sensor.metres_per_unit;
  const Window w = window_for(images_, sensor.camera, numbers.window_px_m / middle_m);
  const float z_units = block_units + tables_.z_units[place];
  if (z_units < numbers.min_z_units) return false;
  const float inverse = w.cells_per_px / (z_units * sensor.metres_per_unit);
  const float x = (sensor.camera.fx_px * block.x_m + tables_.x_px_m[place]) * inverse + w.shift_x;
  const float y = (sensor.camera.fy_px * block.y_m + tables_.y_px_m[place]) * inverse + w.shift_y;
  const int u0 = (static_cast<int>(std::min(std::max(x, 0.0F), w.last_x)) - kImagePadding) << w.choice.level;
  const int v0 = (static_cast<int>(std::min(std::max(y, 0.0F), w.last_y)) - kImagePadding) << w.choice.level;
  const int side = w.choice.window_cells << w.choice.level;
  for (int v = std::max(v0, 0); v < std::min(v0 + side, sensor.camera.height_px); ++v) {
    for (int u = std::max(u0, 0); u < std::min(u0 + side, sensor.camera.width_px); ++u) {
      const float end_units = static_cast<float>(work.ends.at(u, v));
      if (end_units >= z_units + numbers.bias_units && work.ends.is_strong(u, v)) return true;
    }
  }
  return false;
}

void Projective::offer(const FrameWork& work) {
  images_.compute(work.ends, work.kernels, work.pool);
  fill_tables(work.sensor, work.frame);
  const ProjectiveFrame numbers = projective_frame(work.sensor, work.frame, tuning_);
  const VisibleBlocks visible(work.sensor, work.frame, work.pyramid, numbers.window_px_m, numbers.bias_m);
  const std::uint32_t chunks = visible.chunk_count();
  work.updater.begin(work.frame, work.rgb, work.kernels, work.frame_number, chunks + 1, visible.blocks_per_chunk());
  work.pool.parallel_for(chunks, [&](std::uint32_t chunk) {
    visible.for_chunk(chunk, [&](const BlockView& block, BlockClass found) {
      const BlockKey key = work.frame.block_key(block.bx, block.by, block.bz);
      HitRecord* hits = work.hits.find(work.frame.block_id(block.bx, block.by, block.bz));
      const auto strong = [&](int place) { return is_strong(work, numbers, block, place); };
      if (found == BlockClass::all_free) {
        work.updater.offer_all_free(chunk, key, hits, strong);
        return;
      }
      alignas(64) FreeFlags flags;
      if (look(work, numbers, block, flags)) {
        work.updater.offer_some_free(chunk, key, flags, hits, strong);
      } else if (hits != nullptr) {
        work.updater.offer_hits(chunk, key, *hits);
      }
    });
  });
}

}  // namespace g3d::mapper::cpu
