// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/frame_builder.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mapper/cpu/projection_tables.hpp"
#include "mapper/cpu/projective.hpp"
#include "mapper/cpu/visible_blocks.hpp"

namespace g3d::mapper::cuda {
namespace {

static_assert(kPadding == cpu::kImagePadding && kImageLevels == cpu::kMaxLevels && kLargestWindow == cpu::kMaxWindow);

FreeBy free_by(const MapperConfig& config) {
  if (config.mode == MapMode::static_mode) return FreeBy::nothing;
  switch (config.integrator) {
    case IntegratorKind::dda:
      return FreeBy::exact_rays;
    case IntegratorKind::bresenham:
      return FreeBy::thesis_rays;
    case IntegratorKind::projective:
      break;
  }
  return FreeBy::projection;
}

std::uint16_t to_raw(float metres, const hal::CameraModel& camera) {
  const float raw = std::nearbyint(metres * camera.depth_units_per_metre);
  return static_cast<std::uint16_t>(std::clamp(raw, 0.0F, 65535.0F));
}

constexpr std::uint32_t kRayRoom = 640 * 512;  // those of a whole image
constexpr std::uint32_t kColumnRoom = 32768;
constexpr std::size_t kSeen_bytes = std::size_t{32} << 20;
constexpr std::size_t kMostLooks = 64;

std::uint32_t look_room(std::size_t box_blocks) {
  const std::size_t looks = kSeen_bytes / (box_blocks * kSeenWords * sizeof(std::uint32_t));
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(looks, 1, kMostLooks));
}

template <typename From, typename To>
void copy_to(const From& from, To& to) {
  static_assert(sizeof(From) == sizeof(To));
  std::memcpy(&to, &from, sizeof to);
}

}  // namespace

FrameBuilder::FrameBuilder(const MapperConfig& config, const cpu::SensorGeometry& sensor,
                           std::span<const std::uint16_t> scan_mask)
    : config_(config),
      sensor_(sensor),
      pyramid_(sensor.camera.width_px, sensor.camera.height_px),
      mask_(sensor.camera.pixel_count(), std::min(to_raw(config.mask_depth_m, sensor.camera), sensor.far_raw)) {
  for (std::size_t i = 0; i < std::min(scan_mask.size(), mask_.size()); ++i) {
    mask_[i] = std::min(scan_mask[i], sensor.far_raw);
  }
}

MemorySizes FrameBuilder::sizes() const {
  const FreeBy by = free_by(config_);
  return {static_cast<std::uint32_t>(sensor_.camera.width_px),
          static_cast<std::uint32_t>(sensor_.camera.height_px),
          static_cast<std::uint32_t>(sensor_.max_box_blocks()),
          by == FreeBy::exact_rays || by == FreeBy::thesis_rays ? 1U : 0U,
          config_.capacity.blocks,
          config_.capacity.planes,
          config_.capacity.colour_bricks,
          kRayRoom,
          look_room(sensor_.max_box_blocks()),
          kColumnRoom,
          0,
          config_.surface_slots};
}

void FrameBuilder::fill(const cpu::FrameGeometry& frame, bool with_colour, std::uint32_t frame_number,
                        FrameInput& input) const {
  FrameParams& out = input.params;
  input.counters = {};
  const hal::CameraModel& camera = sensor_.camera;
  out = FrameParams{};
  out.width_px = camera.width_px;
  out.height_px = camera.height_px;
  out.near_raw = sensor_.near_raw;
  out.far_raw = sensor_.far_raw;
  out.carve_invalid = config_.carve_invalid ? 1 : 0;
  out.with_colour = with_colour ? 1 : 0;
  out.free_by = free_by(config_);
  out.frame_number = frame_number;
  out.hit_step = config_.steps.hit;
  out.miss_step = config_.steps.miss;
  out.metres_per_unit = sensor_.metres_per_unit;
  out.units_per_metre = camera.depth_units_per_metre;
  out.resolution_m = sensor_.resolution_m;
  out.fx_px = camera.fx_px;
  out.fy_px = camera.fy_px;
  copy_to(frame.rotation, out.rotation);
  copy_to(frame.translation_m, out.translation_m);
  const std::array<std::int32_t, 3> origin{frame.origin.x, frame.origin.y, frame.origin.z};
  const std::array<std::int32_t, 3> blocks{frame.nx_blocks, frame.ny_blocks, frame.nz_blocks};
  copy_to(origin, out.origin);
  copy_to(blocks, out.blocks);
  for (int level = 0; level < kImageLevels; ++level) {
    out.shapes[level] =
        level_shape(static_cast<std::uint32_t>(camera.width_px), static_cast<std::uint32_t>(camera.height_px), level);
  }
  out.pyramid_levels = pyramid_.level_count();
  out.image_levels = 1;
  while (out.image_levels < kImageLevels &&
         std::min(out.shapes[out.image_levels].width, out.shapes[out.image_levels].height) > 1) {
    ++out.image_levels;
  }
  if (out.free_by == FreeBy::projection) fill_projection(frame, out, input.tables);
}

void FrameBuilder::fill_projection(const cpu::FrameGeometry& frame, FrameParams& out, FrameTables& tables) const {
  const cpu::ProjectiveTuning tuning;
  const cpu::ProjectiveFrame numbers = cpu::projective_frame(sensor_, frame, tuning);
  const cpu::VisibleBlocks visible(sensor_, frame, pyramid_, cpu::best_kernels(), numbers.window_px_m, numbers.bias_m);
  const cpu::VisibleBlocks::Numbers boxes = visible.numbers();
  out.super_view = boxes.super_view;
  out.block_view = boxes.block_view;
  out.brick_view = boxes.brick_view;
  copy_to(boxes.super_middle_m, out.super_middle_m);
  copy_to(boxes.block_middle_m, tables.block_middle_m);
  copy_to(boxes.brick_middle_m, out.brick_middle_m);
  copy_to(boxes.supers, out.supers);
  out.bias_m = numbers.bias_m;
  out.window_px_m = numbers.window_px_m;
  out.bias_units = numbers.bias_units;
  out.far_units = numbers.far_units;
  out.far_bias_units = numbers.far_bias_units;
  out.left_px = numbers.left_px;
  out.right_px = numbers.right_px;
  out.top_px = numbers.top_px;
  out.bottom_px = numbers.bottom_px;
  copy_to(numbers.reach_px_m, out.reach_px_m);
  out.min_z_units = numbers.min_z_units;
  const float window_px = cpu::smallest_window_px(sensor_, tuning);
  out.smallest_window = std::clamp(static_cast<int>(std::lround(window_px)), 1, 1 << 12);
  const float least_px = cpu::smallest_footprint_px(sensor_, frame, numbers);
  const hal::CameraModel& camera = sensor_.camera;
  for (int level = 0; level < out.image_levels; ++level) {
    // Larger windows are looked up in the next level, if there is one; see cpu::FootprintImages.
    const float largest_px = (static_cast<float>(kLargestWindow) + 0.5F) * static_cast<float>(1 << level);
    if (level + 1 == out.image_levels || least_px <= largest_px) out.wanted_images |= 1U << level;
    for (int cells = 1; cells <= kLargestWindow; ++cells) {
      WindowPlace& w = out.windows[level][cells];
      w.cells_per_px = 1.0F / static_cast<float>(1 << level);
      const float begin = 0.5F - 0.5F * static_cast<float>(cells) + static_cast<float>(kPadding);
      w.shift_x = (camera.cx_px + 0.5F) * w.cells_per_px + begin;
      w.shift_y = (camera.cy_px + 0.5F) * w.cells_per_px + begin;
      w.first = static_cast<float>(kPadding + 1 - cells);
      w.last_x = static_cast<float>(out.shapes[level].width + kPadding - 1);
      w.last_y = static_cast<float>(out.shapes[level].height + kPadding - 1);
    }
  }
  cpu::fill_projection_tables(sensor_, frame, tables.places);
  for (std::size_t brick = 0; brick < kBricks; ++brick) {
    out.middle_units[brick] = cpu::middle_of_brick(tables.places.z_units, brick * kBrickSize);
  }
}

}  // namespace g3d::mapper::cuda
