// SPDX-License-Identifier: Apache-2.0
#include "mapper/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <vector>

#include "mapper/map_sampler.hpp"
#include "mapper/voxel_tally.hpp"

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;
hal::Result<Grid> target_grid(std::span<const MergeSource> sources, const MergeOptions& options) {
  if (sources.empty()) return Error{Reason::bad_usage, "merging: no map was given; give at least one"};
  if (!hal::is_valid(options.T_world_target))
    return Error{Reason::bad_usage, "merging: the pose of the result is not a pose; check its numbers"};
  float finest_m = sources.front().map->grid().resolution_m;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (!hal::is_valid(sources[i].T_world_map))
      return Error{Reason::bad_usage,
                   fmt::format("merging: the pose of map {} is not a pose; check its numbers", i + 1)};
    finest_m = std::min(finest_m, sources[i].map->grid().resolution_m);
  }
  const float resolution_m = options.resolution_m.value_or(finest_m);
  if (!(resolution_m >= 0.0005F && resolution_m <= 100.0F)) {
    return Error{Reason::bad_usage,
                 fmt::format("merging: resolution {} m is outside of 0.0005..100 m; choose another", resolution_m)};
  }
  return Grid{resolution_m};
}

Error no_room(std::size_t blocks) {
  return {
      Reason::no_capacity,
      fmt::format("merging: {} blocks do not fit into the memory allowed; allow more or merge at a coarser resolution",
                  blocks)};
}

}  // namespace

hal::Result<std::unique_ptr<VoxelMap>> merge_maps(std::span<const MergeSource> sources, const MergeOptions& options) {
  const auto grid = target_grid(sources, options);
  if (!grid) return grid.error();
  std::vector<MapSampler> samplers;
  std::vector<BlockKey> keys;
  for (const MergeSource& source : sources) {
    samplers.emplace_back(*source.map, source.T_world_map, grid.value(), options.T_world_target);
    samplers.back().add_target_keys(keys);
    sort_and_drop_repeats(keys);
  }
  if (keys.size() > 0xFFFFFFFFU / kBricksPerBlock) return no_room(keys.size());
  const auto blocks = static_cast<std::uint32_t>(std::max<std::size_t>(keys.size(), 1));
  std::unique_ptr<VoxelMap> merged;
  try {
    merged = std::make_unique<VoxelMap>(
        grid.value(), options.capacity.value_or(MapCapacity{blocks, blocks, blocks * kBricksPerBlock}));
  } catch (const std::bad_alloc&) {
    return no_room(keys.size());
  }

  BlockValues values;
  BlockTally tallies;
  for (const BlockKey key : keys) {
    tallies.fill({});
    for (std::size_t s = 0; s < samplers.size(); ++s) {
      samplers[s].sample(key, values);
      add_block(tallies, values, sources[s].layer_id);
    }
    if (take_result(tallies, values) && !merged->write_block(key, values)) return no_room(keys.size());
  }
  return merged;
}

}  // namespace g3d::mapper
