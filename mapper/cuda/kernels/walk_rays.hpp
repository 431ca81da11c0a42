// SPDX-License-Identifier: Apache-2.0
// Every pixel's ray marks the voxels that it passes before its last: cpu/kernels/ray_walk.cpp, one ray to a thread. One
// bit per voxel for rays of readings, another for those of pixels without one; the order in which they are set is of no
// account.
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

struct Ray {
  float start[3];  ///< both ends in voxels
  float end[3];
  std::int32_t first[3];  ///< the voxels in which they lie, from the box's origin
  std::int32_t last[3];
  std::int32_t weak_or_strong;  ///< first word of its marks within a block's
};

/// Bit of a voxel among its block's marks: x fastest, which costs a ray less than the order of M-codes.
[[nodiscard]] constexpr std::uint32_t mark_place(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::uint32_t>(x | y << 3 | z << 6);
}

/// Bits of one word that a ray has marked and not yet set: a word has the voxels of some steps in a row.
struct PendingMarks {
  std::uint32_t* word = nullptr;
  std::uint32_t bits = 0;
  std::uint32_t block_id = 0;
};

/// Most are set already: looking first is cheaper than setting.
inline G3D_GPU void set_marks(const Memory& m, const PendingMarks& marks) {
  if ((*marks.word & marks.bits) == marks.bits) return;
  atomic_or(marks.word, marks.bits);
  m.marked_blocks[marks.block_id] = 1;
}

inline G3D_GPU void mark_voxel(const FrameParams& f, const Memory& m, const Ray& ray, const std::int32_t* cell,
                               PendingMarks& marks) {
  for (int axis = 0; axis < 3; ++axis) {
    if (cell[axis] < 0 || cell[axis] >= 8 * f.blocks[axis]) return;  // the box has room for all; see unproject()
  }
  const std::uint32_t id = block_id_at(f, cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
  const std::uint32_t place = mark_place(cell[0] & 7, cell[1] & 7, cell[2] & 7);
  std::uint32_t* word = m.marks + static_cast<std::size_t>(id) * 2 * kMarkWords +
                        static_cast<std::uint32_t>(ray.weak_or_strong) + place / 32;
  const std::uint32_t bit = 1U << (place % 32);
  if (word == marks.word) {
    marks.bits |= bit;
    return;
  }
  if (marks.word != nullptr) set_marks(m, marks);
  marks = {word, bit, id};
}

/// Amanatides & Woo: the axis whose boundary comes first; at a tie x before y before z.
inline G3D_GPU void walk_exactly(const FrameParams& f, const Memory& m, const Ray& ray) {
  float next[3];
  float delta[3];
  std::int32_t step[3];
  std::int32_t cell[3];
  std::int32_t steps = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t key = ray.first[axis] + f.origin[axis];
    const std::int32_t apart = ray.last[axis] - ray.first[axis];
    const float span = ray.end[axis] - ray.start[axis];
    const float length = span < 0 ? -span : span;
    const float inverse = 1.0F / (apart != 0 ? length : 1.0F);
    const float gap = apart > 0 ? static_cast<float>(key - 32767) - ray.start[axis]
                                : ray.start[axis] - static_cast<float>(key - 32768);
    next[axis] = apart != 0 ? gap * inverse : __builtin_inff();
    delta[axis] = inverse;
    step[axis] = apart > 0 ? 1 : -1;
    cell[axis] = ray.first[axis];
    steps += apart < 0 ? -apart : apart;
  }
  PendingMarks marks;
  for (; steps > 0; --steps) {
    mark_voxel(f, m, ray, cell, marks);
    if (next[0] <= next[1] && next[0] <= next[2]) {
      next[0] = next[0] + delta[0];
      cell[0] += step[0];
    } else if (next[1] <= next[2]) {
      next[1] = next[1] + delta[1];
      cell[1] += step[1];
    } else {
      next[2] = next[2] + delta[2];
      cell[2] += step[2];
    }
  }
  if (marks.word != nullptr) set_marks(m, marks);
}

/// Thesis Algorithm 1: one step along the driving axis, the two others when their error term is due.
inline G3D_GPU void walk_as_thesis(const FrameParams& f, const Memory& m, const Ray& ray) {
  std::int32_t count[3];
  std::int32_t step[3];
  std::int32_t cell[3];
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t apart = ray.last[axis] - ray.first[axis];
    count[axis] = apart < 0 ? -apart : apart;
    step[axis] = apart > 0 ? 1 : -1;
    cell[axis] = ray.first[axis];
  }
  const bool x_drives = count[0] >= count[1] && count[0] >= count[2];
  const bool y_drives = !x_drives && count[1] >= count[2];
  const std::int32_t along = x_drives ? count[0] : (y_drives ? count[1] : count[2]);
  std::int32_t error[3];
  for (int axis = 0; axis < 3; ++axis) error[axis] = 2 * count[axis] - along;
  const int drive = x_drives ? 0 : (y_drives ? 1 : 2);
  PendingMarks marks;
  for (std::int32_t steps = along; steps > 0; --steps) {
    mark_voxel(f, m, ray, cell, marks);
    for (int axis = 0; axis < 3; ++axis) {
      const bool due = axis == drive || error[axis] >= 0;
      cell[axis] += due ? step[axis] : 0;
      error[axis] += 2 * count[axis] - (due && axis != drive ? 2 * along : 0);
    }
  }
  if (marks.word != nullptr) set_marks(m, marks);
}

inline constexpr int kRayTileColumns = 32;
inline constexpr int kRayTileRows = 8;

inline G3D_GPU void walk_tile(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  const int across = tiles(f.width_px, kRayTileColumns);
  block.each([&](int t) {
    const int u = tile % across * kRayTileColumns + t % kRayTileColumns;
    const int v = tile / across * kRayTileRows + t / kRayTileColumns;
    if (u >= f.width_px || v >= f.height_px) return;
    const std::uint32_t end_raw = m.ends[0][(v + kPadding) * f.shapes[0].stride + u + kPadding];
    if (end_raw == 0) return;
    const float z_m = static_cast<float>(end_raw) * f.metres_per_unit;
    Ray ray;
    ray.weak_or_strong = m.depth[v * f.width_px + u] != 0 ? kMarkWords : 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float* R = f.rotation + 3 * axis;
      const float row_part = R[1] * m.row_slope[v] + R[2];
      const float p_m = (row_part + m.column_slope[u] * R[0]) * z_m + f.translation_m[axis];
      ray.start[axis] = f.translation_m[axis] / f.resolution_m;
      ray.end[axis] = p_m / f.resolution_m;
      ray.first[axis] = cell_of(ray.start[axis], f.origin[axis]);
      ray.last[axis] = cell_of(ray.end[axis], f.origin[axis]);
    }
    if (f.free_by == FreeBy::exact_rays) {
      walk_exactly(f, m, ray);
    } else {
      walk_as_thesis(f, m, ray);
    }
  });
}

}  // namespace g3d::mapper::cuda
