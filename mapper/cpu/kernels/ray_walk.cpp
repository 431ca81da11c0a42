// SPDX-License-Identifier: Apache-2.0
// Rays walk the frame's byte grid in lockstep, as many as a vector holds and two vectors side by side: one vector's
// step waits for its own comparisons, two hide each other's waiting. Neighbours have nearly the same length and touch
// the same lines.
#include <cmath>
#include <limits>

#include "mapper/cpu/kernels/variant.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {
namespace {

constexpr int kVectorLanes = kVectorBytes / 4;
using Floats = float __attribute__((vector_size(kVectorBytes)));
using Ints = std::int32_t __attribute__((vector_size(kVectorBytes)));

// By reference: a vector this wide as a return value would change the calling convention of the narrower variants.
template <typename Vector, typename Scalar>
inline void load(Vector& v, const Scalar* from) {
  __builtin_memcpy(&v, from, sizeof v);
}

// Several threads may mark one byte, always with the same value: relaxed atomics cost a plain store.
inline void mark(std::uint8_t* grid, const Ints& where, std::uint8_t flag) {
  alignas(64) std::int32_t cells[kVectorLanes];
  __builtin_memcpy(cells, &where, sizeof cells);
#pragma GCC unroll 16
  for (int lane = 0; lane < kVectorLanes; ++lane) __atomic_store_n(grid + cells[lane], flag, __ATOMIC_RELAXED);
}

/// First and last voxel of each ray, relative to the grid's origin, and both ends in voxel units.
struct RayEndsOfRow {
  alignas(64) float end[3][kRayLanes];
  alignas(64) std::int32_t last[3][kRayLanes];
  alignas(64) std::int32_t active[kRayLanes];
  float start[3];
  std::int32_t first[3];
  bool any = false;
};

inline void find_ends(const RayRow& row, RayEndsOfRow& rays) {
  alignas(64) float z_m[kRayLanes];
  std::int32_t any = 0;
  for (int lane = 0; lane < kRayLanes; ++lane) {
    const bool used = lane < row.lanes && row.ends[lane] != 0 && (row.depth[lane] != 0) == row.strong;
    rays.active[lane] = used ? 1 : 0;
    z_m[lane] = used ? static_cast<float>(row.ends[lane]) * row.metres_per_unit : 0.0F;
    any |= rays.active[lane];
  }
  rays.any = any != 0;
  for (int axis = 0; axis < 3; ++axis) {
    rays.start[axis] = row.translation[axis] / row.resolution_m;
    rays.first[axis] = static_cast<std::int32_t>(std::ceil(rays.start[axis])) + 32767 - row.origin[axis];
    for (int lane = 0; lane < kRayLanes; ++lane) {
      const float p =
          (row.row_part[axis] + row.column_slope[lane] * row.column[axis]) * z_m[lane] + row.translation[axis];
      rays.end[axis][lane] = p / row.resolution_m;
      rays.last[axis][lane] = static_cast<std::int32_t>(std::ceil(rays.end[axis][lane])) + 32767 - row.origin[axis];
    }
  }
}

/// Amanatides & Woo 1987, branch-free: the axis whose boundary comes first; at a tie x before y before z.
struct ExactWalk {
  Floats tx, ty, tz, dx, dy, dz;
  Ints sx, sy, sz, cell, steps;

  [[gnu::always_inline]] void start(const float (*t_first)[kRayLanes], const float (*t_delta)[kRayLanes],
                                    const std::int32_t (*stride)[kRayLanes], const std::int32_t* step_count, int from,
                                    std::int32_t first_cell) {
    load(tx, t_first[0] + from);
    load(ty, t_first[1] + from);
    load(tz, t_first[2] + from);
    load(dx, t_delta[0] + from);
    load(dy, t_delta[1] + from);
    load(dz, t_delta[2] + from);
    load(sx, stride[0] + from);
    load(sy, stride[1] + from);
    load(sz, stride[2] + from);
    load(steps, step_count + from);
    cell = Ints{} + first_cell;
  }

  [[gnu::always_inline]] void step(std::uint8_t* grid, const Ints& spare, std::uint8_t flag) {
    const Ints target = steps > 0 ? cell : spare;
    mark(grid, target, flag);
    const Ints x_first = (tx <= ty) & (tx <= tz);
    const Ints y_first = ~x_first & (ty <= tz);
    const Ints z_first = ~x_first & ~y_first;
    tx = x_first ? tx + dx : tx;
    ty = y_first ? ty + dy : ty;
    tz = z_first ? tz + dz : tz;
    cell += x_first ? sx : (y_first ? sy : sz);
    steps -= 1;
  }
};

/// Thesis Algorithm 1: one step along the driving axis, the two others when their error term is due.
struct ThesisWalk {
  Ints error_a, error_b, gain_a, gain_b, loss, drive, step_a, step_b, cell, steps;

  [[gnu::always_inline]] void start(const std::int32_t (*error)[kRayLanes], const std::int32_t (*gain)[kRayLanes],
                                    const std::int32_t* loss_of, const std::int32_t (*stride)[kRayLanes],
                                    const std::int32_t* step_count, int from, std::int32_t first_cell) {
    load(error_a, error[0] + from);
    load(error_b, error[1] + from);
    load(gain_a, gain[0] + from);
    load(gain_b, gain[1] + from);
    load(loss, loss_of + from);
    load(drive, stride[0] + from);
    load(step_a, stride[1] + from);
    load(step_b, stride[2] + from);
    load(steps, step_count + from);
    cell = Ints{} + first_cell;
  }

  [[gnu::always_inline]] void step(std::uint8_t* grid, const Ints& spare, std::uint8_t flag) {
    const Ints target = steps > 0 ? cell : spare;
    mark(grid, target, flag);
    const Ints zero{};
    const Ints a_due = error_a >= 0;
    const Ints b_due = error_b >= 0;
    cell += drive + (a_due ? step_a : zero) + (b_due ? step_b : zero);
    error_a += gain_a - (a_due ? loss : zero);
    error_b += gain_b - (b_due ? loss : zero);
    steps -= 1;
  }
};

/// Until the longest of their rays has taken its steps.
template <typename Walk>
[[gnu::always_inline]] inline void walk_two(Walk& left, Walk& right, const RayRow& row, const std::int32_t* steps) {
  std::int32_t most = 0;
  for (int lane = 0; lane < 2 * kVectorLanes; ++lane) most = steps[lane] > most ? steps[lane] : most;
  const Ints spare = Ints{} + row.spare_cell;
  std::uint8_t* const grid = row.grid;
  const std::uint8_t flag = row.strong ? kStrongFree : kWeakFree;
  for (; most > 0; --most) {
    left.step(grid, spare, flag);
    right.step(grid, spare, flag);
  }
}

}  // namespace

// As many steps as the keys of both ends are apart, so that a ray ends where its reading lies; the last voxel is not
// marked.
void walk_rays(const RayRow& row) {
  RayEndsOfRow rays;
  find_ends(row, rays);
  if (!rays.any) return;
  alignas(64) float t_first[3][kRayLanes];
  alignas(64) float t_delta[3][kRayLanes];
  alignas(64) std::int32_t stride[3][kRayLanes];
  alignas(64) std::int32_t step_count[kRayLanes] = {};
  for (int axis = 0; axis < 3; ++axis) {
    // Voxel k covers (k - 32768, k - 32767] in units of the resolution.
    const std::int32_t key = rays.first[axis] + row.origin[axis];
    const float upper = static_cast<float>(key - 32767);
    const float lower = static_cast<float>(key - 32768);
    const float start = rays.start[axis];
    for (int lane = 0; lane < kRayLanes; ++lane) {
      const std::int32_t apart = rays.last[axis][lane] - rays.first[axis];
      const std::int32_t count = apart < 0 ? -apart : apart;
      const float span = rays.end[axis][lane] - start;
      const float length = span < 0 ? -span : span;
      const float inverse = 1.0F / (apart != 0 ? length : 1.0F);
      const float gap = apart > 0 ? upper - start : start - lower;
      t_first[axis][lane] = apart != 0 ? gap * inverse : std::numeric_limits<float>::infinity();
      t_delta[axis][lane] = inverse;
      stride[axis][lane] = apart > 0 ? row.stride[axis] : -row.stride[axis];
      step_count[lane] += rays.active[lane] != 0 ? count : 0;
    }
  }
  const std::int32_t first_cell =
      rays.first[0] * row.stride[0] + rays.first[1] * row.stride[1] + rays.first[2] * row.stride[2];
  for (int lane = 0; lane < kRayLanes; lane += 2 * kVectorLanes) {
    ExactWalk left;
    ExactWalk right;
    left.start(t_first, t_delta, stride, step_count, lane, first_cell);
    right.start(t_first, t_delta, stride, step_count, lane + kVectorLanes, first_cell);
    walk_two(left, right, row, step_count + lane);
  }
}

void walk_bresenham(const RayRow& row) {
  RayEndsOfRow rays;
  find_ends(row, rays);
  if (!rays.any) return;
  alignas(64) std::int32_t error[2][kRayLanes];
  alignas(64) std::int32_t gain[2][kRayLanes];
  alignas(64) std::int32_t loss_of[kRayLanes];
  alignas(64) std::int32_t stride[3][kRayLanes];
  alignas(64) std::int32_t step_count[kRayLanes];
  for (int lane = 0; lane < kRayLanes; ++lane) {
    const std::int32_t ax = rays.last[0][lane] - rays.first[0];
    const std::int32_t ay = rays.last[1][lane] - rays.first[1];
    const std::int32_t az = rays.last[2][lane] - rays.first[2];
    const std::int32_t nx = ax < 0 ? -ax : ax;
    const std::int32_t ny = ay < 0 ? -ay : ay;
    const std::int32_t nz = az < 0 ? -az : az;
    const std::int32_t sx = ax > 0 ? row.stride[0] : -row.stride[0];
    const std::int32_t sy = ay > 0 ? row.stride[1] : -row.stride[1];
    const std::int32_t sz = az > 0 ? row.stride[2] : -row.stride[2];
    const bool x_drives = (nx >= ny) & (nx >= nz);
    const bool y_drives = !x_drives & (ny >= nz);
    const std::int32_t along = x_drives ? nx : (y_drives ? ny : nz);
    const std::int32_t first = x_drives ? ny : nx;
    const std::int32_t second = (x_drives | y_drives) ? nz : ny;
    stride[0][lane] = x_drives ? sx : (y_drives ? sy : sz);
    stride[1][lane] = x_drives ? sy : sx;
    stride[2][lane] = (x_drives | y_drives) ? sz : sy;
    error[0][lane] = 2 * first - along;
    error[1][lane] = 2 * second - along;
    gain[0][lane] = 2 * first;
    gain[1][lane] = 2 * second;
    loss_of[lane] = 2 * along;
    step_count[lane] = rays.active[lane] != 0 ? along : 0;
  }
  const std::int32_t first_cell =
      rays.first[0] * row.stride[0] + rays.first[1] * row.stride[1] + rays.first[2] * row.stride[2];
  for (int lane = 0; lane < kRayLanes; lane += 2 * kVectorLanes) {
    ThesisWalk left;
    ThesisWalk right;
    left.start(error, gain, loss_of, stride, step_count, lane, first_cell);
    right.start(error, gain, loss_of, stride, step_count, lane + kVectorLanes, first_cell);
    walk_two(left, right, row, step_count + lane);
  }
}

}  // namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT
