// SPDX-License-Identifier: Apache-2.0
// Floors in two dimensions for tests of planners: made up ones of every kind, and real floor plans where there are any.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nav/cell_grid.hpp"

namespace g3d::tests {

/// Blobs, bars and single cells of obstacles and of the unknown on free ground.
[[nodiscard]] nav::CellGrid<nav::CellState> random_floor(std::uint64_t seed, int columns, int rows);

/// Rooms of 3-9 m on both sides of corridors, doors of 0.8-1.2 m, furniture, closed rooms; 5 cm cells.
[[nodiscard]] nav::CellGrid<nav::CellState> office_floor(std::uint64_t seed, int side_cells);

/// Costs of any value anywhere, in patches; walls and unknown cells among them.
[[nodiscard]] nav::CellGrid<std::uint8_t> random_costs(std::uint64_t seed, int columns, int rows);

/// A map_server floor plan; nothing if it cannot be read.
[[nodiscard]] std::optional<nav::CellGrid<nav::CellState>> mapped_floor(const std::string& yaml_path);
/// Yaml files of all real floor plans that are there.
[[nodiscard]] std::vector<std::string> real_floor_plans();

}  // namespace g3d::tests
