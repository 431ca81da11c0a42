// SPDX-License-Identifier: Apache-2.0
#include "mapper/cuda/ask_grid.hpp"

#include <algorithm>
#include <cstring>

namespace g3d::mapper::cuda {

bool ask_grid(Card& card, const GridSpread& spread, std::span<const std::uint8_t> costs,
              std::span<std::uint32_t> distances) {
  const auto columns = static_cast<std::size_t>(spread.columns);
  const auto rows = static_cast<std::size_t>(spread.rows);
  const bool has_start =
      spread.start_x >= 0 && spread.start_y >= 0 && spread.start_x < spread.columns && spread.start_y < spread.rows;
  if (!has_start || columns * rows != costs.size() || distances.size() != costs.size()) return false;
  if (costs.size() > card.grid_room()) return false;
  const GridQuestion& question = card.grid_question();
  *question.spread = spread;
  std::memcpy(question.costs, costs.data(), costs.size());
  if (!card.spread_grid()) return false;
  std::memcpy(distances.data(), question.distances, distances.size_bytes());
  const std::size_t start =
      static_cast<std::size_t>(spread.start_y) * columns + static_cast<std::size_t>(spread.start_x);
  return distances[start] == 0 && std::all_of(distances.begin(), distances.end(), [&](std::uint32_t distance) {
           return distance <= spread.max_cost || distance == kNotReached;
         });
}

}  // namespace g3d::mapper::cuda
