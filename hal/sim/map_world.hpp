// SPDX-License-Identifier: Apache-2.0
// Floor plans of map_server (yaml + pgm) as worlds: occupied cells become walls of one height, with a floor and, if
// asked for, a ceiling. Unknown cells are walls where they touch free ones, so that no ray leaves the mapped building
// through a cell that nobody has seen; elsewhere they are air. A robot starts in the middle of the widest free part.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/image/pgm.hpp"
#include "hal/result.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// The yaml file. Unknown keys are skipped, as map_server does.
struct MapYaml {
  std::string image;           ///< as written: relative to the yaml file, or absolute
  double resolution_m = 0.05;  ///< 0.001..10
  double origin_x_m = 0.0;     ///< lower left corner of the lower left cell
  double origin_y_m = 0.0;
  bool negate = false;
  double occupied_thresh = 0.65;  ///< 0..1; a cell is occupied above
  double free_thresh = 0.196;     ///< 0..1; free below
};

/// A rectangle of the floor, world frame.
struct FloorRectangle {
  double min_x_m = 0.0;
  double min_y_m = 0.0;
  double max_x_m = 0.0;
  double max_y_m = 0.0;
};

struct MapWorldOptions {
  double wall_height_m = 2.5;
  bool ceiling = true;
};

/// `file` is what errors call the text. A turned origin is refused: nothing here draws turned grids.
[[nodiscard]] Result<MapYaml> parse_map_yaml(std::string_view text, std::string_view file);
[[nodiscard]] Result<World> make_map_world(const MapYaml& yaml, const GreyImage& image, const MapWorldOptions& options,
                                           std::string_view file);
/// `crop`: only this piece of it.
[[nodiscard]] Result<World> load_map_world(const std::string& yaml_path, const MapWorldOptions& options = {},
                                           const std::optional<FloorRectangle>& crop = std::nullopt);

}  // namespace g3d::hal
