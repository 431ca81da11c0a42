// SPDX-License-Identifier: Apache-2.0
// All numbers of one frame that the kernels need, computed by the host with the CPU twin's own functions, so that both
// twins start from the same bits. Plain data: it is copied to the card as it is, and compiled for it.
#pragma once

#include <cstdint>

#include "mapper/cpu/kernels/kernels.hpp"
#include "mapper/rgbo.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kPadding = 8;        ///< cells around every image of ray ends, all zero
inline constexpr int kImageLevels = 7;    ///< level l has cells of 2^l pixels
inline constexpr int kLargestWindow = 7;  ///< cells
inline constexpr int kBaseLevel = 2;      ///< the depth pyramid begins with cells of 4 pixels
inline constexpr int kPyramidLevels = 4;  ///< levels 2..5 are kept; coarser ones are gathered from the last

struct ImageShape {
  std::int32_t width;  ///< cells without padding
  std::int32_t height;
  std::int32_t stride;  ///< cells
  std::int32_t rows;    ///< with padding
};

/// Where a window of some size lies in its image; see cpu::Projective::Window.
struct alignas(8) WindowPlace {
  float cells_per_px;
  float shift_x;
  float shift_y;
  float first;
  float last_x;
  float last_y;
};

enum class FreeBy : std::int32_t { nothing, projection, exact_rays, thesis_rays };

struct FrameParams {
  std::int32_t width_px;
  std::int32_t height_px;
  std::int32_t near_raw;
  std::int32_t far_raw;
  std::int32_t carve_invalid;
  std::int32_t with_colour;
  FreeBy free_by;
  std::uint32_t frame_number;
  std::uint8_t hit_step;  ///< UpdateSteps
  std::uint8_t miss_step;
  std::uint8_t reserved[2];

  float metres_per_unit;
  float units_per_metre;
  float resolution_m;
  float fx_px;
  float fy_px;
  float rotation[9];       ///< R of T_world_camera, row-major
  float translation_m[3];  ///< t of T_world_camera
  std::int32_t origin[3];  ///< lowest voxel of the frame's box
  std::int32_t blocks[3];  ///< of the box along each axis
  std::int32_t supers[3];  ///< groups of 4x4x4 blocks

  // The box of blocks, as cpu::VisibleBlocks sees it
  cpu::BoxView super_view;
  cpu::BoxView block_view;
  cpu::BoxView brick_view;
  float super_middle_m[3];
  float brick_middle_m[3][8];
  float bias_m;
  std::int32_t pyramid_levels;  ///< of the CPU twin, coarse ones included

  // The projective test, as cpu::Projective has it
  float window_px_m;
  float bias_units;
  float far_units;
  float far_bias_units;
  float left_px;
  float right_px;
  float top_px;
  float bottom_px;
  float reach_px_m[4];
  float min_z_units;
  std::int32_t smallest_window;  ///< cells at level 0
  std::int32_t image_levels;
  std::uint32_t wanted_images;  ///< bit l: windows of level l may be asked for
  ImageShape shapes[kImageLevels];
  WindowPlace windows[kImageLevels][kLargestWindow + 1];
  float middle_units[8];  ///< depth of a brick's middle behind the block's first voxel
};

[[nodiscard]] constexpr UpdateSteps steps_of(const FrameParams& f) { return {f.hit_step, f.miss_step}; }

/// Numbers that neighbouring threads read at different places.
struct FrameTables {
  float block_middle_m[3][64];  ///< see cpu::VisibleBlocks
  cpu::ProjectionTables places;
};

/// What the kernels of one frame count. Zero at its start, copied back at its end.
struct FrameCounters {
  std::uint32_t valid;
  std::uint32_t too_near;
  std::uint32_t far;              ///< all others have no reading
  std::uint32_t records;          ///< blocks in which something was measured
  std::uint32_t items;            ///< blocks to look at
  std::uint32_t changed;          ///< blocks that the frame changed
  std::uint32_t refused;          ///< for lack of memory
  std::uint32_t refused_imports;  ///< of all frames so far
  std::uint32_t reserved[4];
};

struct FrameInput {
  FrameParams params;
  FrameCounters counters;
  FrameTables tables;
};

}  // namespace g3d::mapper::cuda
