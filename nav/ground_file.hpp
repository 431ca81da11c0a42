// SPDX-License-Identifier: Apache-2.0
// `ground.pgm` + `ground.yaml` as map_server reads them (mode trinary): 0 occupied, 254 free, 205 unknown, first row at
// the top (highest y), origin at the lower left corner.
#pragma once

#include <string>

#include "hal/image/pgm.hpp"
#include "hal/result.hpp"
#include "nav/ground_grid.hpp"

namespace g3d::nav {

inline constexpr std::uint8_t kOccupiedGrey = 0;
inline constexpr std::uint8_t kFreeGrey = 254;
inline constexpr std::uint8_t kUnknownGrey = 205;

/// An empty grid becomes one unknown cell: image formats have no empty images.
[[nodiscard]] hal::GreyImage ground_image(const GroundGrid& ground);
[[nodiscard]] std::string ground_yaml(const GroundGrid& ground, const std::string& image_name);

/// Writes `STEM.pgm` and `STEM.yaml`, each by temporary file and rename; the image first, so that a yaml never lacks
/// one.
[[nodiscard]] hal::Result<void> write_ground(const GroundGrid& ground, const std::string& stem);

}  // namespace g3d::nav
