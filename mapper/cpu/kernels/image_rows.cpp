// SPDX-License-Identifier: Apache-2.0
// Row loops over the depth image: what each reading is, where it lies in the map, and maxima and minima of neighbours.
#include <algorithm>
#include <cmath>

#include "mapper/cpu/kernels/variant.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {
namespace {

// Two neighbouring readings lie on one surface if they differ by at most 1/24 of the nearer one: a floor seen at 8
// degrees by a Kinect still does, the silhouette of a chair does not. A missing neighbour counts as an edge.
inline bool is_edge(std::uint32_t d, std::uint32_t n) {
  const std::uint32_t difference = d > n ? d - n : n - d;
  return difference * 24U > std::min(d, n);
}

inline std::int32_t spread_three_bits(std::int32_t v) { return (v & 1) | ((v & 2) << 2) | ((v & 4) << 4); }

}  // namespace

RowCounts classify_row(const ClassifyRow& row) {
  RowCounts counts;
  std::uint32_t valid = 0;
  std::uint32_t too_near = 0;
  std::uint32_t far = 0;
  const std::uint16_t* __restrict depth = row.depth;
  std::uint16_t* __restrict ends = row.ends;
  for (int u = 0; u < row.width; ++u) {
    const std::uint16_t d = depth[u];
    const bool is_near = d != 0 && d < row.near_raw;
    const bool is_far = d > row.far_raw;
    too_near += is_near ? 1U : 0U;
    far += is_far ? 1U : 0U;
    valid += (d >= row.near_raw && d <= row.far_raw) ? 1U : 0U;
    const std::uint16_t capped = std::min(d, row.far_raw);
    ends[u] = d >= row.near_raw ? capped : std::uint16_t{0};
  }
  const auto flag = [&](int u, int left, int right) {
    const std::uint32_t d = depth[u];
    const bool edge = is_edge(d, depth[left]) | is_edge(d, depth[right]) | is_edge(d, row.above[u]) | is_edge(d, row.below[u]);
    return static_cast<std::uint8_t>(edge ? 0 : kColourFlag);
  };
  const int last = row.width - 1;
  std::uint8_t* __restrict colour = row.colour_flag;
  colour[0] = flag(0, 0, std::min(1, last));
  for (int u = 1; u < last; ++u) colour[u] = flag(u, u - 1, u + 1);
  colour[last] = flag(last, std::max(0, last - 1), last);
  counts.valid = valid;
  counts.too_near = too_near;
  counts.far = far;
  counts.invalid = static_cast<std::uint32_t>(row.width) - valid - too_near - far;
  return counts;
}

void unproject_row(const UnprojectRow& row) {
  const std::uint16_t* __restrict depth = row.depth;
  const float* __restrict slope = row.column_slope;
  std::uint32_t* __restrict block_id = row.block_id;
  std::uint16_t* __restrict place = row.place;
  const UnprojectRow r = row;
  for (int u = 0; u < r.width; ++u) {
    const std::uint16_t d = depth[u];
    const bool trusted = d >= r.near_raw && d <= r.far_raw;
    // Untrusted readings are computed as the nearest trusted one, so that every number stays inside the box.
    const float z = static_cast<float>(trusted ? d : r.near_raw) * r.metres_per_unit;
    const float x_m = (r.row_part[0] + slope[u] * r.column[0]) * z + r.translation[0];
    const float y_m = (r.row_part[1] + slope[u] * r.column[1]) * z + r.translation[1];
    const float z_m = (r.row_part[2] + slope[u] * r.column[2]) * z + r.translation[2];
    const std::int32_t kx = static_cast<std::int32_t>(std::ceil(x_m / r.resolution_m)) + 32767 - r.origin[0];
    const std::int32_t ky = static_cast<std::int32_t>(std::ceil(y_m / r.resolution_m)) + 32767 - r.origin[1];
    const std::int32_t kz = static_cast<std::int32_t>(std::ceil(z_m / r.resolution_m)) + 32767 - r.origin[2];
    const std::int32_t id = (kx >> 3) + (ky >> 3) * r.nx_blocks + (kz >> 3) * r.nxy_blocks;
    block_id[u] = trusted ? static_cast<std::uint32_t>(id) : kNoBlock;
    place[u] = static_cast<std::uint16_t>(spread_three_bits(kx & 7) | (spread_three_bits(ky & 7) << 1) |
                                          (spread_three_bits(kz & 7) << 2));
  }
}

void max_filter_row(const std::uint16_t* a, const std::uint16_t* b, int shift, int count, std::uint16_t* out) {
  const std::uint16_t* __restrict pa = a;
  const std::uint16_t* __restrict pb = b;
  std::uint16_t* __restrict po = out;
  for (int x = 0; x < count; ++x) po[x] = std::max(std::max(pa[x], pa[x + shift]), std::max(pb[x], pb[x + shift]));
}

void halve_max_row(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out) {
  const std::uint16_t* __restrict pa = a;
  const std::uint16_t* __restrict pb = b;
  std::uint16_t* __restrict po = out;
  for (int x = 0; x < count; ++x)
    po[x] = std::max(std::max(pa[2 * x], pa[2 * x + 1]), std::max(pb[2 * x], pb[2 * x + 1]));
}

void halve_min_row(const std::uint16_t* a, const std::uint16_t* b, int count, std::uint16_t* out) {
  const std::uint16_t* __restrict pa = a;
  const std::uint16_t* __restrict pb = b;
  std::uint16_t* __restrict po = out;
  for (int x = 0; x < count; ++x)
    po[x] = std::min(std::min(pa[2 * x], pa[2 * x + 1]), std::min(pb[2 * x], pb[2 * x + 1]));
}

}  // namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT
