// SPDX-License-Identifier: Apache-2.0
// Row loops over the depth image: what each reading is, where it lies in the map, and maxima and minima of neighbours.
#include <algorithm>
#include <cmath>

#include "mapper/cpu/kernels/variant.hpp"

namespace g3d::mapper::cpu::G3D_KERNEL_VARIANT {
namespace {

// Two neighbouring readings lie on one surface if they differ by at most 5/128 of the nearer one: a floor seen at 9
// degrees by a Kinect still does, the silhouette of a chair does not. A missing neighbour counts as an edge.
inline bool is_edge(std::uint16_t d, std::uint16_t n) {
  const std::uint16_t nearer = d < n ? d : n;
  const std::uint16_t farther = d < n ? n : d;
  const std::uint16_t difference = static_cast<std::uint16_t>(farther - nearer);
  return difference > static_cast<std::uint16_t>((nearer >> 5) + (nearer >> 7));
}

inline std::int32_t spread_three_bits(std::int32_t v) { return (v & 1) | ((v & 2) << 2) | ((v & 4) << 4); }

}  // namespace

RowCounts classify_row(const ClassifyRow& row) {
  const std::uint16_t* __restrict depth = row.depth;
  const std::uint16_t* __restrict above = row.above;
  const std::uint16_t* __restrict below = row.below;
  std::uint16_t* __restrict ends = row.ends;
  std::uint8_t* __restrict colour = row.colour_flag;
  const std::uint16_t near_raw = row.near_raw;
  const std::uint16_t far_raw = row.far_raw;
  const int width = row.width;
  for (int u = 0; u < width; ++u) {
    const std::uint16_t capped = depth[u] < far_raw ? depth[u] : far_raw;
    ends[u] = depth[u] >= near_raw ? capped : std::uint16_t{0};
  }
  std::uint32_t readings = 0;
  std::uint32_t from_near = 0;
  std::uint32_t far = 0;
  for (int u = 0; u < width; ++u) {
    readings += depth[u] != 0;
    from_near += depth[u] >= near_raw;
    far += depth[u] > far_raw;
  }
  std::uint8_t* __restrict blind = row.blind;
  for (int u = 0; u < width; ++u) blind[u] = depth[u] == 0;
  for (int u = 1; u < width - 1; ++u) {
    const std::uint16_t d = depth[u];
    const bool edge = is_edge(d, depth[u - 1]) | is_edge(d, depth[u + 1]) | is_edge(d, above[u]) | is_edge(d, below[u]);
    colour[u] = edge ? std::uint8_t{0} : kColourFlag;
  }
  // At the border the neighbour that is not there is the pixel itself.
  for (const int u : {0, width - 1}) {
    const std::uint16_t d = depth[u];
    const std::uint16_t beside = width > 1 ? depth[u == 0 ? 1 : u - 1] : d;
    const bool edge = is_edge(d, beside) | is_edge(d, above[u]) | is_edge(d, below[u]);
    colour[u] = edge ? std::uint8_t{0} : kColourFlag;
  }
  RowCounts counts;
  counts.valid = from_near - far;
  counts.too_near = readings - from_near;
  counts.far = far;
  counts.invalid = static_cast<std::uint32_t>(width) - readings;
  return counts;
}

void carry_down(const std::uint16_t* depth, int count, std::uint16_t* last, std::uint16_t* ends) {
  const std::uint16_t* __restrict d = depth;
  std::uint16_t* __restrict l = last;
  std::uint16_t* __restrict e = ends;
  for (int i = 0; i < count; ++i) {
    const std::uint16_t nearest = e[i] < l[i] ? e[i] : l[i];
    e[i] = d[i] != 0 ? e[i] : nearest;
    l[i] = d[i] != 0 ? d[i] : l[i];
  }
}

void bound_up(const BoundRow& row) {
  const std::uint16_t* __restrict depth = row.depth;
  const std::uint16_t* __restrict mask = row.mask;
  std::uint16_t* __restrict last = row.last;
  std::uint16_t* __restrict ends = row.ends;
  const std::uint16_t near_raw = row.near_raw;
  for (int i = 0; i < row.count; ++i) {
    const std::uint16_t nearest = ends[i] < last[i] ? ends[i] : last[i];
    const std::uint16_t capped = mask[i] < nearest ? mask[i] : nearest;
    const bool carves = (nearest != kUnbounded) & (nearest >= near_raw);
    const std::uint16_t weak = carves ? capped : std::uint16_t{0};
    ends[i] = depth[i] != 0 ? ends[i] : weak;
    last[i] = depth[i] != 0 ? depth[i] : last[i];
  }
}

void unproject_row(const UnprojectRow& row) {
  const std::uint16_t* __restrict depth = row.depth;
  const float* __restrict slope = row.column_slope;
  std::uint32_t* __restrict block_id = row.block_id;
  std::uint16_t* __restrict place = row.place;
  const UnprojectRow r = row;
  for (int u = 0; u < r.width; ++u) {
    const std::uint16_t d = depth[u];
    const bool counts = d != 0 && d <= r.far_raw;
    // Others are computed as the nearest trusted one, so that every number stays inside the box.
    const float z = static_cast<float>(counts ? d : r.near_raw) * r.metres_per_unit;
    const float x_m = (r.row_part[0] + slope[u] * r.column[0]) * z + r.translation[0];
    const float y_m = (r.row_part[1] + slope[u] * r.column[1]) * z + r.translation[1];
    const float z_m = (r.row_part[2] + slope[u] * r.column[2]) * z + r.translation[2];
    const std::int32_t kx = static_cast<std::int32_t>(std::ceil(x_m / r.resolution_m)) + 32767 - r.origin[0];
    const std::int32_t ky = static_cast<std::int32_t>(std::ceil(y_m / r.resolution_m)) + 32767 - r.origin[1];
    const std::int32_t kz = static_cast<std::int32_t>(std::ceil(z_m / r.resolution_m)) + 32767 - r.origin[2];
    const std::int32_t id = (kx >> 3) + (ky >> 3) * r.nx_blocks + (kz >> 3) * r.nxy_blocks;
    block_id[u] = counts ? static_cast<std::uint32_t>(id) : kNoBlock;
    place[u] = static_cast<std::uint16_t>(spread_three_bits(kx & 7) | (spread_three_bits(ky & 7) << 1) |
                                          (spread_three_bits(kz & 7) << 2));
  }
  const std::uint8_t* __restrict colour_flag = row.colour_flag;
  std::uint32_t* __restrict code = row.code;
  for (int u = 0; u < r.width; ++u) {
    const std::uint32_t kind = depth[u] < r.near_raw ? 2U : static_cast<std::uint32_t>(colour_flag[u] >> 1);
    code[u] = block_id[u] << 11 | static_cast<std::uint32_t>(place[u]) << 2 | kind;
  }
  std::uint8_t* __restrict starts = row.starts;
  starts[0] = block_id[0] != kNoBlock ? 1 : 0;
  for (int u = 1; u < r.width; ++u) {
    const bool differs = (code[u] != code[u - 1]) | (block_id[u] != block_id[u - 1]);
    starts[u] = static_cast<std::uint8_t>(differs & (block_id[u] != kNoBlock));
  }
}

void drop_repeats(const std::uint32_t* code, const std::uint32_t* code_above, int width, std::uint8_t* starts) {
  const std::uint32_t* __restrict own = code;
  const std::uint32_t* __restrict above = code_above;
  std::uint8_t* __restrict out = starts;
  for (int u = 1; u < width - 1; ++u) {
    const bool fresh = (own[u] != above[u - 1]) & (own[u] != above[u]) & (own[u] != above[u + 1]);
    out[u] = static_cast<std::uint8_t>(out[u] & (fresh ? 1 : 0));
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
