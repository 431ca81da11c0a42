// SPDX-License-Identifier: Apache-2.0
// World files: one solid per line, `#` begins a comment, metres and degrees. (x, y) is the middle of the plan, z the
// underside. Optional numbers stand in [ ].
//
//   box      x y z  size_x size_y size_z  [yaw]
//   sphere   x y z  radius                                      here z is the centre
//   cylinder x y z  radius height
//   pole     x y z  radius height                               a thin cylinder: at most 0.1 m
//   cone     x y z  radius height  [top_radius]
//   stairs   x y z  width run rise steps  [yaw]                 climbs along its +x from the middle of the first edge
//   shelves  x y z  width depth height boards  [yaw]            open unit, width along its x
//   floor    x y z  size_x size_y  thickness                    z is the upper side
//   room     x y z  size_x size_y size_z  thickness             inner size; walls, floor and ceiling outside of it
//   person   height radius  t,x,y [t,x,y ...]                   walks straight lines from waypoint to waypoint
//   start    x y heading                                        where a robot may begin; the first robot takes the
//   first
//
// after the numbers, in any order:
//   color=#rrggbb  color2=#rrggbb  texture=checker:METRES | stripes:METRES
//   dark    swallows the infrared: colour, but no depth         glass   infrared passes, colour is tinted
//   room only: floor=#rrggbb  floor2=#rrggbb (a checkered floor)  ceiling=#rrggbb  open (no ceiling)
#pragma once

#include <string_view>

#include "hal/result.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

/// `file` is what errors call the text.
[[nodiscard]] Result<World> parse_world(std::string_view text, std::string_view file);

}  // namespace g3d::hal
