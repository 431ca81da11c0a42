// SPDX-License-Identifier: Apache-2.0
// The integer scale (thesis equations 13-15, 26-28): metres <-> 16-bit voxel coordinates of one axis.
// Integer k covers ((k - 32768) r, (k - 32767) r] and is published at its centre (k - 32767.5) r.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace g3d::mapper {

inline constexpr int kAxisBits = 16;
inline constexpr std::int32_t kAxisCells = 1 << kAxisBits;
inline constexpr std::int32_t kAxisOffset_cells = (1 << (kAxisBits - 1)) - 1;  // 2^15 - 1

/// Voxel coordinates on the three axes, each 0..65535 when inside the grid.
struct VoxelIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  bool operator==(const VoxelIndex&) const = default;
};

[[nodiscard]] constexpr bool is_inside_grid(std::int32_t k) { return k >= 0 && k < kAxisCells; }
[[nodiscard]] constexpr bool is_inside_grid(const VoxelIndex& v) {
  return is_inside_grid(v.x) && is_inside_grid(v.y) && is_inside_grid(v.z);
}

struct Grid {
  float resolution_m = 0.05F;

  /// 2^15 - 1 + ceil(x / r). float32 division, so that every twin rounds alike. |x| must be far below 2^31 r.
  [[nodiscard]] std::int32_t to_index(float x_m) const {
    return kAxisOffset_cells + static_cast<std::int32_t>(std::ceil(x_m / resolution_m));
  }
  [[nodiscard]] VoxelIndex to_index(float x_m, float y_m, float z_m) const {
    return {to_index(x_m), to_index(y_m), to_index(z_m)};
  }
  /// Centre of voxel k. Double: it is for people and files, not for twins.
  [[nodiscard]] double centre_m(std::int32_t k) const {
    return (static_cast<double>(k) - 32767.5) * static_cast<double>(resolution_m);
  }
  [[nodiscard]] std::array<double, 3> centre_m(const VoxelIndex& v) const {
    return {centre_m(v.x), centre_m(v.y), centre_m(v.z)};
  }
  bool operator==(const Grid&) const = default;
};

}  // namespace g3d::mapper
