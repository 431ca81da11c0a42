// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/grid_walls.hpp"

#include <algorithm>
#include <cassert>

namespace g3d::hal {
namespace {

constexpr float kTiny = 1e-12F;  // stands for a direction of zero: the quotient stays finite

float away_from_zero(float d) { return d < 0.0F ? std::min(d, -kTiny) : std::max(d, kTiny); }

}  // namespace

GridWalls::GridWalls(int width_cells, int height_cells, float cell_m, std::array<float, 2> origin_m, float z_low_m,
                     float z_high_m, const std::vector<std::uint8_t>& solid)
    : width_cells_(width_cells),
      height_cells_(height_cells),
      cell_m_(cell_m),
      origin_m_(origin_m),
      z_low_m_(z_low_m),
      z_high_m_(z_high_m),
      distance_cells_(solid.size()) {
  assert(width_cells > 0 && height_cells > 0 && width_cells <= kMaxSide_cells && height_cells <= kMaxSide_cells);
  assert(solid.size() == static_cast<std::size_t>(width_cells) * static_cast<std::size_t>(height_cells));
  // Two passes of the chessboard distance transform; beyond the border nothing is solid.
  const auto at = [this](int i, int j) -> int {
    if (i < 0 || j < 0 || i >= width_cells_ || j >= height_cells_) return 255;
    return distance(i, j);
  };
  const auto put = [this](int i, int j, int d) {
    distance_cells_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_cells_) +
                    static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(std::min(d, 255));
  };
  for (int j = 0; j < height_cells; ++j) {
    for (int i = 0; i < width_cells; ++i) {
      const std::size_t cell =
          static_cast<std::size_t>(j) * static_cast<std::size_t>(width_cells) + static_cast<std::size_t>(i);
      const int before = std::min({at(i - 1, j), at(i - 1, j - 1), at(i, j - 1), at(i + 1, j - 1)});
      put(i, j, solid[cell] != 0 ? 0 : before + 1);
    }
  }
  for (int j = height_cells - 1; j >= 0; --j) {
    for (int i = width_cells - 1; i >= 0; --i) {
      const int after = std::min({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1), at(i - 1, j + 1)});
      put(i, j, std::min(distance(i, j), after + 1));
    }
  }
}

GridWalls::Hit GridWalls::cast(const std::array<float, 3>& origin_m, const std::array<float, 3>& direction,
                               float t_max) const {
  // In units of cells from the grid's corner.
  const float scale = 1.0F / cell_m_;
  const float o[2] = {(origin_m[0] - origin_m_[0]) * scale, (origin_m[1] - origin_m_[1]) * scale};
  const float inverse[2] = {1.0F / away_from_zero(direction[0] * scale), 1.0F / away_from_zero(direction[1] * scale)};
  const float d[2] = {direction[0] * scale, direction[1] * scale};
  const int size[2] = {width_cells_, height_cells_};

  // The part of the ray within the walls' height and the grid's border.
  const float inverse_z = 1.0F / away_from_zero(direction[2]);
  const float z_a = (z_low_m_ - origin_m[2]) * inverse_z;
  const float z_b = (z_high_m_ - origin_m[2]) * inverse_z;
  float t = std::max(0.0F, std::min(z_a, z_b));
  float t_end = std::min(t_max, std::max(z_a, z_b));
  int axis = t > 0.0F ? 2 : (inverse[0] * inverse[0] < inverse[1] * inverse[1] ? 0 : 1);
  for (int k = 0; k < 2; ++k) {
    const float a = (0.0F - o[k]) * inverse[k];
    const float b = (static_cast<float>(size[k]) - o[k]) * inverse[k];
    if (std::min(a, b) > t) {
      t = std::min(a, b);
      axis = k;
    }
    t_end = std::min(t_end, std::max(a, b));
  }
  if (!(t < t_end)) return {kMiss, 0};

  int cell[2];
  for (int k = 0; k < 2; ++k) cell[k] = std::clamp(static_cast<int>(o[k] + t * d[k]), 0, size[k] - 1);
  for (;;) {
    const int free_cells = distance(cell[0], cell[1]);
    if (free_cells == 0) return {t, axis};
    // All cells less than `free_cells` away are free: leave that square in one step.
    const int reach = free_cells - 1;
    float leave[2];
    for (int k = 0; k < 2; ++k) {
      const int edge = inverse[k] > 0.0F ? cell[k] + reach + 1 : cell[k] - reach;
      leave[k] = (static_cast<float>(edge) - o[k]) * inverse[k];
    }
    axis = leave[0] < leave[1] ? 0 : 1;
    const int other = 1 - axis;
    t = std::max(t, leave[axis]);
    if (!(t < t_end)) return {kMiss, 0};
    const int step = inverse[axis] > 0.0F ? free_cells : -free_cells;
    const int low = std::max(cell[other] - reach, 0);
    const int high = std::min(cell[other] + reach, size[other] - 1);
    cell[axis] += step;
    if (cell[axis] < 0 || cell[axis] >= size[axis]) return {kMiss, 0};
    cell[other] = std::clamp(static_cast<int>(o[other] + t * d[other]), low, high);
  }
}

float GridWalls::leaves_walls_at(float z_m, float direction_z) const {
  const float inverse_z = 1.0F / away_from_zero(direction_z);
  return std::max((z_low_m_ - z_m) * inverse_z, (z_high_m_ - z_m) * inverse_z);
}

bool GridWalls::is_solid(float x_m, float y_m, float z_m) const {
  if (!(z_m >= z_low_m_ && z_m <= z_high_m_)) return false;
  const float i = (x_m - origin_m_[0]) / cell_m_;
  const float j = (y_m - origin_m_[1]) / cell_m_;
  if (!(i >= 0.0F && j >= 0.0F && i < static_cast<float>(width_cells_) && j < static_cast<float>(height_cells_))) {
    return false;
  }
  return is_solid_cell(static_cast<int>(i), static_cast<int>(j));
}

}  // namespace g3d::hal
