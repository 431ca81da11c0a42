// SPDX-License-Identifier: Apache-2.0
// Is a voxel seen through? cpu::Projective, one voxel at a time.
#pragma once

#include "mapper/cuda/kernels/visible.hpp"

namespace g3d::mapper::cuda {

/// Windows of one size: where they lie, and the image in which up to four looks find the farthest end in one.
struct Window {
  std::int32_t level;
  std::int32_t cells;
  WindowPlace place;
  const std::uint16_t* image;
  std::int32_t stride;
  std::int32_t shift;  ///< between the looks, 0: one is enough
};

/// Which windows voxels around a depth need: level | cells << 3; see cpu::FootprintImages::choose.
inline G3D_GPU std::uint32_t choose_window(const FrameParams& f, float z_units) {
  const float z_m = most(z_units, f.min_z_units) * f.metres_per_unit;
  float cells = f.window_px_m / z_m;
  int level = 0;
  while (cells > static_cast<float>(kLargestWindow) + 0.5F && level + 1 < f.image_levels) {
    cells *= 0.5F;
    ++level;
  }
  const int smallest = level == 0 ? least(f.smallest_window, kLargestWindow) : 4;
  const int halves = static_cast<int>(2.0F * cells + 1.0F);  // the nearest whole number is half of it
  return static_cast<std::uint32_t>(level | least(most(halves / 2, smallest), kLargestWindow) << 3);
}

inline G3D_GPU Window window_of(const FrameParams& f, const Memory& m, std::uint32_t choice) {
  Window window;
  window.level = static_cast<std::int32_t>(choice & 7U);
  window.cells = static_cast<std::int32_t>(choice >> 3);
  window.place = f.windows[window.level][window.cells];
  window.image = window.cells >= 4 ? m.four[window.level] : window.cells >= 2 ? m.two : m.ends[0];
  window.stride = f.shapes[window.level].stride;
  window.shift = window.cells >= 4 ? window.cells - 4 : window.cells >= 2 ? window.cells - 2 : 0;
  return window;
}

/// Farthest end within a window that begins at a padded cell.
inline G3D_GPU std::uint32_t window_maximum(const Window& w, int x, int y) {
  const std::uint16_t* first = w.image + y * w.stride + x;
  if (w.shift == 0) return *first;
  const std::uint16_t* below = first + w.shift * w.stride;
  return most(most(first[0], first[w.shift]), most(below[0], below[w.shift]));
}

/// A block as the projective test sees it.
struct ProjectedBlock {
  float x_px_m;
  float y_px_m;
  float z_units;
};
inline G3D_GPU ProjectedBlock project_block(const FrameParams& f, const Corner& corner) {
  return {f.fx_px * corner.x_m, f.fy_px * corner.y_m, f.units_per_metre * corner.z_m};
}

/// A voxel's place from its block's first one; see cpu::ProjectionTables.
struct VoxelOffset {
  float x_px_m;
  float y_px_m;
  float z_units;
};

/// How far a ray must reach to show that a voxel at this depth is free.
inline G3D_GPU float needed_units(const FrameParams& f, float z_units) {
  const float beyond = z_units + f.bias_units;
  return z_units + f.far_bias_units <= f.far_units ? least(beyond, f.far_units) : beyond;
}

inline G3D_GPU bool is_seen_through(const FrameParams& f, const ProjectedBlock& block, const Window& window,
                                    bool at_border, const VoxelOffset& voxel) {
  const WindowPlace& w = window.place;
  const float z_units = block.z_units + voxel.z_units;
  if (z_units < f.min_z_units) return false;
  // cells_per_px is a power of two, so that the order of operations is of no account; see cpu::Projective.
  const float inverse = 1.0F / (z_units * f.metres_per_unit) * w.cells_per_px;
  const float x_px_m = block.x_px_m + voxel.x_px_m;
  const float y_px_m = block.y_px_m + voxel.y_px_m;
  const float x = least(most(x_px_m * inverse + w.shift_x, w.first), w.last_x);
  const float y = least(most(y_px_m * inverse + w.shift_y, w.first), w.last_y);
  const std::uint32_t end = window_maximum(window, static_cast<int>(x), static_cast<int>(y));
  if (!(static_cast<float>(end) >= needed_units(f, z_units))) return false;
  if (!at_border) return true;
  const float z_m = z_units * f.metres_per_unit;
  return x_px_m + f.reach_px_m[0] >= f.left_px * z_m && x_px_m - f.reach_px_m[1] <= f.right_px * z_m &&
         y_px_m + f.reach_px_m[2] >= f.top_px * z_m && y_px_m - f.reach_px_m[3] <= f.bottom_px * z_m;
}

/// Is the voxel free by measured rays alone? Asked for occupied voxels that only a ray without a reading seems to pass.
inline G3D_GPU bool is_strongly_free(const FrameParams& f, const Memory& m, const ProjectedBlock& block,
                                     const Window& window, const VoxelOffset& voxel) {
  const WindowPlace& w = window.place;
  const float z_units = block.z_units + voxel.z_units;
  if (z_units < f.min_z_units) return false;
  const float inverse = 1.0F / (z_units * f.metres_per_unit) * w.cells_per_px;
  const float x = (block.x_px_m + voxel.x_px_m) * inverse + w.shift_x;
  const float y = (block.y_px_m + voxel.y_px_m) * inverse + w.shift_y;
  const int x0 = static_cast<int>(least(most(x, w.first), w.last_x)) - kPadding;
  const int y0 = static_cast<int>(least(most(y, w.first), w.last_y)) - kPadding;
  const ImageShape& shape = f.shapes[window.level];
  std::uint32_t farthest = 0;
  for (int cy = most(y0, 0); cy < least(y0 + window.cells, shape.height); ++cy) {
    for (int cx = most(x0, 0); cx < least(x0 + window.cells, shape.width); ++cx) {
      std::uint32_t end = 0;
      const int cell = (cy + kPadding) * shape.stride + cx + kPadding;
      if (window.level > 0) {
        end = m.strong[window.level][cell];
      } else if (m.depth[cy * f.width_px + cx] != 0) {
        end = m.ends[0][cell];
      }
      farthest = most(farthest, end);
    }
  }
  return static_cast<float>(farthest) >= needed_units(f, z_units) && farthest != 0;
}

}  // namespace g3d::mapper::cuda
