// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_grid.hpp"

#include <algorithm>
#include <limits>

namespace g3d::nav {
namespace {

using mapper::BlockKey;
using mapper::State;
using mapper::VoxelIndex;

/// Voxel layers in the band, both ends included.
struct Layers {
  std::int32_t low;
  std::int32_t high;
};

Layers layers_of(const mapper::Grid& grid, const HeightBand& band) {
  Layers layers{mapper::kAxisCells, -1};
  for (std::int32_t k = 0; k < mapper::kAxisCells; ++k) {
    const double centre_m = grid.centre_m(k);
    if (centre_m < static_cast<double>(band.low_m) || centre_m > static_cast<double>(band.high_m)) continue;
    layers.low = std::min(layers.low, k);
    layers.high = k;
  }
  return layers;
}

struct Box {
  std::int32_t x_low = std::numeric_limits<std::int32_t>::max(), y_low = x_low;
  std::int32_t x_high = -1, y_high = -1;
};

/// Calls `visit(index, state)` for every known voxel in the layers.
template <typename Visit>
void for_each_known(const mapper::VoxelMap& map, const std::vector<BlockKey>& keys, const Layers& layers, Visit visit) {
  mapper::BlockValues values;
  for (const BlockKey key : keys) {
    const VoxelIndex origin = mapper::block_origin(key);
    if (origin.z + mapper::kBlockSide_cells <= layers.low || origin.z > layers.high) continue;
    map.read_block(key, values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const State state = mapper::state_of(values[i]);
      if (state == State::unknown) continue;
      const VoxelIndex place = mapper::decode(i);
      const VoxelIndex v{origin.x + place.x, origin.y + place.y, origin.z + place.z};
      if (v.z >= layers.low && v.z <= layers.high) visit(v, state);
    }
  }
}

std::int32_t median(std::vector<std::int32_t>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void limit_side(std::int32_t& low, std::int32_t& high, std::int32_t middle) {
  if (high - low < kMaxGroundSide_cells) return;
  low = std::clamp(middle - kMaxGroundSide_cells / 2, low, high - kMaxGroundSide_cells + 1);
  high = low + kMaxGroundSide_cells - 1;
}

void limit_box(Box& box, const std::vector<BlockKey>& keys) {
  if (box.x_high - box.x_low < kMaxGroundSide_cells && box.y_high - box.y_low < kMaxGroundSide_cells) return;
  std::vector<std::int32_t> xs;
  std::vector<std::int32_t> ys;
  for (const BlockKey key : keys) {
    xs.push_back(mapper::block_origin(key).x);
    ys.push_back(mapper::block_origin(key).y);
  }
  limit_side(box.x_low, box.x_high, median(xs));
  limit_side(box.y_low, box.y_high, median(ys));
}

}  // namespace

GroundGrid project_to_ground(const mapper::VoxelMap& map, const HeightBand& band) {
  const Layers layers = layers_of(map.grid(), band);
  const std::vector<BlockKey> keys = map.sorted_keys();
  Box box;
  for_each_known(map, keys, layers, [&](const VoxelIndex& v, State) {
    box.x_low = std::min(box.x_low, v.x);
    box.y_low = std::min(box.y_low, v.y);
    box.x_high = std::max(box.x_high, v.x);
    box.y_high = std::max(box.y_high, v.y);
  });
  GroundGrid ground;
  ground.resolution_m = map.grid().resolution_m;
  if (box.x_high < 0) return ground;
  limit_box(box, keys);
  const double half_cell_m = 0.5 * static_cast<double>(ground.resolution_m);
  ground.origin_x_m = map.grid().centre_m(box.x_low) - half_cell_m;
  ground.origin_y_m = map.grid().centre_m(box.y_low) - half_cell_m;
  ground.columns = box.x_high - box.x_low + 1;
  ground.rows = box.y_high - box.y_low + 1;
  ground.cells.assign(static_cast<std::size_t>(ground.columns) * static_cast<std::size_t>(ground.rows), State::unknown);
  for_each_known(map, keys, layers, [&](const VoxelIndex& v, State state) {
    if (v.x < box.x_low || v.x > box.x_high || v.y < box.y_low || v.y > box.y_high) return;
    State& cell = ground.cells[static_cast<std::size_t>(v.y - box.y_low) * static_cast<std::size_t>(ground.columns) +
                               static_cast<std::size_t>(v.x - box.x_low)];
    if (state == State::occupied || cell == State::unknown) cell = state;
  });
  return ground;
}

}  // namespace g3d::nav
