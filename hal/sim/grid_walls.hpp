// SPDX-License-Identifier: Apache-2.0
// Walls on a horizontal grid of square cells, all of one height: a floor plan extruded upwards. Every cell knows how
// far the nearest wall is (chessboard distance), so that a ray crosses an empty hall in a few jumps instead of
// hundreds of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace g3d::hal {

class GridWalls {
 public:
  static constexpr int kMaxSide_cells = 16386;  ///< the largest floor plan with a border around it

  GridWalls() = default;
  /// `solid`: width * height, row-major from the cell at `origin` (lowest x and y); nonzero is wall from z_low to
  /// z_high.
  GridWalls(int width_cells, int height_cells, float cell_m, std::array<float, 2> origin_m, float z_low_m,
            float z_high_m, const std::vector<std::uint8_t>& solid);

  struct Hit {
    float t = 0.0F;  ///< ray parameter; kMiss if there is none
    int axis = 0;    ///< axis of the face that was hit: 0 x, 1 y, 2 z (top or underside)
  };
  static constexpr float kMiss = 3.0e38F;

  /// First wall along origin + t * direction for 0 <= t < t_max. The direction need not have length 1.
  [[nodiscard]] Hit cast(const std::array<float, 3>& origin_m, const std::array<float, 3>& direction,
                         float t_max) const;
  /// Ray parameter at which a ray from height `z_m`, between the walls' feet and tops, rises or falls out of them.
  [[nodiscard]] float leaves_walls_at(float z_m, float direction_z) const;
  [[nodiscard]] bool is_solid(float x_m, float y_m, float z_m) const;

  [[nodiscard]] int width_cells() const { return width_cells_; }
  [[nodiscard]] int height_cells() const { return height_cells_; }
  [[nodiscard]] float cell_m() const { return cell_m_; }
  [[nodiscard]] std::array<float, 2> origin_m() const { return origin_m_; }
  [[nodiscard]] float z_low_m() const { return z_low_m_; }
  [[nodiscard]] float z_high_m() const { return z_high_m_; }
  [[nodiscard]] bool is_solid_cell(int i, int j) const { return distance(i, j) == 0; }
  /// Chessboard distance in cells to the nearest wall, at most 255; 0 in a wall.
  [[nodiscard]] int distance(int i, int j) const {
    return distance_cells_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_cells_) +
                           static_cast<std::size_t>(i)];
  }

 private:
  int width_cells_ = 0;
  int height_cells_ = 0;
  float cell_m_ = 0.05F;
  std::array<float, 2> origin_m_{};
  float z_low_m_ = 0.0F;
  float z_high_m_ = 2.5F;
  std::vector<std::uint8_t> distance_cells_;
};

}  // namespace g3d::hal
