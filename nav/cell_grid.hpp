// SPDX-License-Identifier: Apache-2.0
// A rectangle of square cells on the floor, sized once. Cell (x, y) covers [origin + x * resolution, + resolution].
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace g3d::nav {

struct Cell {
  int x = 0;
  int y = 0;
  bool operator==(const Cell&) const = default;
};

/// What is known of a cell for a robot's body.
enum class CellState : std::uint8_t { unknown, free, occupied };

// Costs as costmap_2d defines them (navigation stack, "inflation").
inline constexpr std::uint8_t kFreeCost = 0;
inline constexpr std::uint8_t kInscribedCost = 253;  ///< centre of the robot here: it certainly touches
inline constexpr std::uint8_t kLethalCost = 254;     ///< an obstacle itself
inline constexpr std::uint8_t kUnknownCost = 255;

template <typename T>
struct CellGrid {
  double resolution_m = 0.05;
  double origin_x_m = 0.0;  ///< lower left corner of cell (0, 0), world frame
  double origin_y_m = 0.0;
  int columns = 0;
  int rows = 0;
  std::vector<T> cells;  ///< y * columns + x

  CellGrid() = default;
  CellGrid(double resolution, double origin_x, double origin_y, int columns_, int rows_, T value)
      : resolution_m(resolution),
        origin_x_m(origin_x),
        origin_y_m(origin_y),
        columns(columns_),
        rows(rows_),
        cells(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), value) {}

  [[nodiscard]] bool contains(Cell c) const { return c.x >= 0 && c.y >= 0 && c.x < columns && c.y < rows; }
  [[nodiscard]] std::size_t index(Cell c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c.x);
  }
  [[nodiscard]] Cell cell(std::size_t i) const {
    return {static_cast<int>(i % static_cast<std::size_t>(columns)),
            static_cast<int>(i / static_cast<std::size_t>(columns))};
  }
  [[nodiscard]] T& at(Cell c) { return cells[index(c)]; }
  [[nodiscard]] const T& at(Cell c) const { return cells[index(c)]; }
  /// May lie outside: ask contains().
  [[nodiscard]] Cell cell_of(double x_m, double y_m) const {
    return {static_cast<int>(std::floor((x_m - origin_x_m) / resolution_m)),
            static_cast<int>(std::floor((y_m - origin_y_m) / resolution_m))};
  }
  [[nodiscard]] double centre_x_m(Cell c) const { return origin_x_m + (c.x + 0.5) * resolution_m; }
  [[nodiscard]] double centre_y_m(Cell c) const { return origin_y_m + (c.y + 0.5) * resolution_m; }
};

}  // namespace g3d::nav
