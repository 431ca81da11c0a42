// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/map_start.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr double kRoom_m = 0.25;

}  // namespace

std::optional<PlanarPose> widest_start(const GridWalls& walls, const std::vector<std::uint8_t>& is_free) {
  const int width = walls.width_cells();
  const int height = walls.height_cells();
  assert(is_free.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // Chessboard distances count to the far edge of the wall's cell.
  const int room_cells = static_cast<int>(std::ceil(kRoom_m / double{walls.cell_m()})) + 1;
  std::vector<std::uint8_t> open(is_free.size());
  for (std::size_t i = 0; i < open.size(); ++i) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(width));
    const int y = static_cast<int>(i / static_cast<std::size_t>(width));
    open[i] = is_free[i] != 0 && walls.distance(x, y) >= room_cells ? 1 : 0;
  }
  std::size_t widest = 0;
  std::size_t best_cell = 0;
  std::vector<std::size_t> part;
  for (std::size_t first = 0; first < open.size(); ++first) {
    if (open[first] == 0) continue;
    part.assign(1, first);
    open[first] = 0;
    for (std::size_t n = 0; n < part.size(); ++n) {
      const int x = static_cast<int>(part[n] % static_cast<std::size_t>(width));
      const auto visit = [&](std::size_t cell) {
        if (open[cell] == 0) return;
        open[cell] = 0;
        part.push_back(cell);
      };
      if (x > 0) visit(part[n] - 1);
      if (x + 1 < width) visit(part[n] + 1);
      if (part[n] >= static_cast<std::size_t>(width)) visit(part[n] - static_cast<std::size_t>(width));
      if (part[n] + static_cast<std::size_t>(width) < open.size()) visit(part[n] + static_cast<std::size_t>(width));
    }
    if (part.size() <= widest) continue;
    widest = part.size();
    const auto room = [&](std::size_t cell) {
      return walls.distance(static_cast<int>(cell % static_cast<std::size_t>(width)),
                            static_cast<int>(cell / static_cast<std::size_t>(width)));
    };
    best_cell = *std::max_element(part.begin(), part.end(), [&](std::size_t a, std::size_t b) {
      return room(a) != room(b) ? room(a) < room(b) : a > b;
    });
  }
  if (widest == 0) return std::nullopt;
  const double cell_m = walls.cell_m();
  const std::size_t column = best_cell % static_cast<std::size_t>(width);
  const std::size_t row = best_cell / static_cast<std::size_t>(width);
  return PlanarPose{double{walls.origin_m()[0]} + (static_cast<double>(column) + 0.5) * cell_m,
                    double{walls.origin_m()[1]} + (static_cast<double>(row) + 0.5) * cell_m, 0.0};
}

}  // namespace g3d::hal
