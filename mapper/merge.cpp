// SPDX-License-Identifier: Apache-2.0
#include "mapper/merge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>
#include <vector>

#include "mapper/block_source.hpp"
#include "mapper/cpu/thread_pool.hpp"
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

constexpr std::size_t kPart_blocks = 256;

/// Some blocks of the result.
class Part {
 public:
  explicit Part(const std::vector<MapSampler>& samplers)
      : samplers_(samplers), values_(kPart_blocks), is_known_(kPart_blocks) {}

  /// Returns how many of them it takes.
  std::size_t take(std::span<const BlockKey> keys) {
    keys_ = keys.first(std::min(kPart_blocks, keys.size()));
    return keys_.size();
  }
  void make(std::span<const MergeSource> sources) {
    for (std::size_t i = 0; i < keys_.size(); ++i) is_known_[i] = make_block(keys_[i], sources, values_[i]) ? 1 : 0;
  }
  /// False if there is no room.
  bool write_to(VoxelMap& map) const {
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (is_known_[i] != 0 && !map.write_block(keys_[i], values_[i])) return false;
    }
    return true;
  }

 private:
  bool make_block(BlockKey key, std::span<const MergeSource> sources, BlockValues& out) {
    std::size_t knowing = 0;
    std::size_t first = 0;
    for (std::size_t s = 0; s < samplers_.size(); ++s) {
      if (!samplers_[s].sample(key, knowing == 0 ? out : found_)) continue;
      if (knowing == 1) {
        tally_.clear();
        tally_.add(out, sources[first].layer_id);
      }
      if (knowing > 0) tally_.add(found_, sources[s].layer_id);
      if (knowing++ == 0) first = s;
    }
    // What one map alone knows is as it says.
    return knowing > 1 ? tally_.take_result(out) : knowing == 1 && is_known(out);
  }

  std::vector<MapSampler> samplers_;  ///< its own: each remembers where it looked last
  std::span<const BlockKey> keys_;
  std::vector<BlockValues> values_;
  std::vector<std::uint8_t> is_known_;
  BlockTally tally_;
  BlockValues found_;
};

}  // namespace

hal::Result<std::unique_ptr<VoxelMap>> merge_maps(std::span<const MergeSource> sources, const MergeOptions& options) {
  const auto grid = target_grid(sources, options);
  if (!grid) return grid.error();
  std::vector<MapSampler> samplers;
  std::vector<BlockKey> keys;
  for (const MergeSource& source : sources) {
    samplers.emplace_back(*source.map, source.T_world_map, grid.value(), options.T_world_target, options.walls);
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

  // Parts of the result are made side by side and written one after the other.
  cpu::ThreadPool pool(std::max(options.threads, 1));
  std::vector<Part> parts;
  for (int i = 0; i < pool.threads(); ++i) parts.emplace_back(samplers);
  for (std::span<const BlockKey> left = keys; !left.empty();) {
    for (Part& part : parts) left = left.subspan(part.take(left));
    pool.parallel_for(static_cast<std::uint32_t>(parts.size()), [&](std::uint32_t i) { parts[i].make(sources); });
    for (const Part& part : parts) {
      if (!part.write_to(*merged)) return no_room(keys.size());
    }
  }
  return merged;
}

}  // namespace g3d::mapper
