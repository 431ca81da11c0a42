// SPDX-License-Identifier: Apache-2.0
// Colour of a surface point: material and texture under two fixed lamps, a lamp on the camera, and a little haze.
#pragma once

#include <array>
#include <cstdint>

#include "hal/sim/tile_kernels.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

struct Shade {
  Rgb colour;
  float cos_incidence = 0.0F;  ///< between ray and surface normal, 0..1
};

/// `t`: depth of the hit along `direction` (world frame); `inverse_length`: 1 / |direction|.
[[nodiscard]] Shade shade_solid(const PreparedSolid& solid, const Material& material,
                                const std::array<float, 3>& direction, float t, float inverse_length);
/// Grid walls have no material of their own: patches of muted colours, so that places can be told apart.
[[nodiscard]] Shade shade_grid(const GridWalls& grid, int axis, const std::array<float, 3>& origin_m,
                               const std::array<float, 3>& direction, float t, float inverse_length);
[[nodiscard]] Rgb shade_sky(const std::array<float, 3>& direction, float inverse_length);
/// What a pane in front does to a colour.
[[nodiscard]] Rgb tint(const Rgb& behind, const Rgb& pane);

}  // namespace g3d::hal
