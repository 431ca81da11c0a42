// SPDX-License-Identifier: Apache-2.0
// A piece of a map_server floor plan: large buildings are explored in pieces. What is cut off does not exist; the
// world that is raised from the piece closes its border with walls, as it does at the border of every picture.
#pragma once

#include <string_view>

#include "hal/image/pgm.hpp"
#include "hal/result.hpp"
#include "hal/sim/map_world.hpp"

namespace g3d::hal {

/// Keeps the cells whose middle lies in the rectangle; those that are kept stay where they are. A rectangle that holds
/// none is an error (bad_usage) that says where the map lies. `file` is what errors call the map.
[[nodiscard]] Result<void> crop_map(MapYaml& yaml, GreyImage& image, const FloorRectangle& crop, std::string_view file);

}  // namespace g3d::hal
