// SPDX-License-Identifier: Apache-2.0
// Worlds and camera paths by what a person types: a built-in name or a file.
#pragma once

#include <optional>
#include <string>

#include "hal/result.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/map_world.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// A built-in name, a world file, or a map_server yaml file (known by .yaml or .yml). `crop`: a piece of a map_server
/// map; of other worlds there are none (bad_usage).
[[nodiscard]] Result<World> load_world(const std::string& name_or_file,
                                       const std::optional<FloorRectangle>& crop = std::nullopt);
/// A built-in name or a camera path file.
[[nodiscard]] Result<CameraPath> load_camera_path(const std::string& name_or_file);

}  // namespace g3d::hal
