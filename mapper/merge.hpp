// SPDX-License-Identifier: Apache-2.0
// Several maps with known poses become one, voxel by voxel: level = clamp(16 + sum(O_i - 16)) over the maps that know
// the voxel, colour from the one that is surest of it (highest level; ties: lowest layer id, then lowest RGB). All maps
// are summed before anything is clamped, so the result is a function of the set: neither order nor grouping of the
// arguments counts.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/geometry.hpp"
#include "hal/result.hpp"
#include "mapper/map_sampler.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct MergeSource {
  const VoxelMap* map = nullptr;
  hal::Pose T_world_map;
  std::uint64_t layer_id = 0;
};

struct MergeOptions {
  std::optional<float> resolution_m;    ///< none: the finest of the sources'
  hal::Pose T_world_target;             ///< where the merged grid stands
  std::optional<MapCapacity> capacity;  ///< none: what the result can need at most
  int threads = 1;                      ///< the result is the same with any
  Walls walls = Walls::closed;          ///< of maps that are turned
};

/// Sources are taken exactly where they can be, else resampled: see MapSampler.
/// Errors: bad_usage (no source, bad pose or resolution), no_capacity. Thread: no source may be written meanwhile.
[[nodiscard]] hal::Result<std::unique_ptr<VoxelMap>> merge_maps(std::span<const MergeSource> sources,
                                                                const MergeOptions& options = {});

}  // namespace g3d::mapper
