// SPDX-License-Identifier: Apache-2.0
// Floor plans for fast experiments with exploration: what is solid, where a round body can go from the start, and what
// of it a camera could ever see. Made by seeded generators or read from map_server files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::tests {

struct FlatWorld {
  std::string name;
  nav::CellGrid<std::uint8_t> solid;  ///< 1 where there is a wall or furniture; the border is
};

inline constexpr double kBodyRadius_m = 0.18;

[[nodiscard]] const std::vector<std::string_view>& flat_world_names();
/// One of flat_world_names(); the variant moves walls and furniture.
[[nodiscard]] FlatWorld make_flat_world(std::string_view name, std::uint64_t variant);
/// A map_server yaml file at 5 cm, cropped around the middle of its free cells to at most `max_side_m`. Throws if it
/// cannot be read.
[[nodiscard]] FlatWorld read_flat_world(const std::string& yaml_path, double max_side_m);

/// Distance in metres from each cell's centre to the nearest solid cell's centre, exact (Felzenszwalb and
/// Huttenlocher), at most 2 m.
[[nodiscard]] nav::CellGrid<float> clearance_of(const nav::CellGrid<std::uint8_t>& solid);
/// Body centres from which a disc of kBodyRadius_m touches nothing.
[[nodiscard]] nav::CellGrid<std::uint8_t> standing_room(const nav::CellGrid<std::uint8_t>& solid);
/// The part of `room` that is 8-connected to `from`.
[[nodiscard]] nav::CellGrid<std::uint8_t> connected_part(const nav::CellGrid<std::uint8_t>& room, nav::Cell from);
/// A seeded place and heading in the largest connected part, at least 5 cm from touching.
[[nodiscard]] hal::PlanarPose choose_start(const FlatWorld& world, std::uint64_t seed);

/// 1 for cells that at least three poses of a 0.2 m lattice within `reachable` can see, turned any way.
[[nodiscard]] nav::CellGrid<std::uint8_t> observable_cells(const nav::CellGrid<std::uint8_t>& solid,
                                                           const nav::CellGrid<std::uint8_t>& reachable, double near_m,
                                                           double far_m);

/// Walks the cells of a ray: visit(index, distance_m of entry) until it returns false or max_m or the border is
/// reached.
template <typename T, typename Visit>
void walk_ray(const nav::CellGrid<T>& grid, double x_m, double y_m, double dx, double dy, double max_m,
              const Visit& visit) {
  const double r = grid.resolution_m;
  const double fx = (x_m - grid.origin_x_m) / r;
  const double fy = (y_m - grid.origin_y_m) / r;
  int cx = static_cast<int>(fx);
  int cy = static_cast<int>(fy);
  const int sx = dx > 0 ? 1 : -1;
  const int sy = dy > 0 ? 1 : -1;
  constexpr double kFar = 1e18;
  const double step_x = dx != 0 ? r / (dx > 0 ? dx : -dx) : kFar;
  const double step_y = dy != 0 ? r / (dy > 0 ? dy : -dy) : kFar;
  double next_x = dx != 0 ? (dx > 0 ? cx + 1 - fx : fx - cx) * step_x : kFar;
  double next_y = dy != 0 ? (dy > 0 ? cy + 1 - fy : fy - cy) * step_y : kFar;
  double at = 0;
  while (at <= max_m && cx >= 0 && cy >= 0 && cx < grid.columns && cy < grid.rows) {
    if (!visit(static_cast<std::size_t>(cy) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(cx),
               at)) {
      return;
    }
    if (next_x < next_y) {
      at = next_x;
      next_x += step_x;
      cx += sx;
    } else {
      at = next_y;
      next_y += step_y;
      cy += sy;
    }
  }
}

}  // namespace g3d::tests
