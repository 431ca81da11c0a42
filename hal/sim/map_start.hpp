// SPDX-License-Identifier: Apache-2.0
// Where to put a robot on a floor plan that names no place for it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/sim/grid_walls.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

/// In the widest connected part of the cells that are free and at least 0.25 m from every wall, the one that is
/// farthest from them; nothing if there is none. `is_free`: per cell of the grid, nonzero where the plan says that the
/// floor is free; what nobody has seen is not.
[[nodiscard]] std::optional<PlanarPose> widest_start(const GridWalls& walls, const std::vector<std::uint8_t>& is_free);

}  // namespace g3d::hal
