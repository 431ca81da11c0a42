// SPDX-License-Identifier: Apache-2.0
// Questions in bulk, answered from the map in the host's memory: the twin of cuda/kernels/cast_rays.hpp, equal to the
// last bit. Thread: while nobody writes the map. Nothing is allocated after construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "mapper/cpu/frame_geometry.hpp"
#include "mapper/cpu/thread_pool.hpp"
#include "mapper/look.hpp"
#include "mapper/pool.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::cpu {

/// Room for one hit per ray.
void cast_bulk_rays(const VoxelMap& map, std::span<const BulkRay> rays, std::span<BulkHit> hits, ThreadPool& pool);

/// A look from a pose, its gain still zero. Out of the grid it sees nothing.
[[nodiscard]] Look look_from(const SensorGeometry& sensor, const hal::RigidTransform& T_world_camera);
/// A ray for every pixel of these columns and rows, row by row, as far as far_m of depth; at most rays.size(). Returns
/// how many.
std::size_t rays_from(const SensorGeometry& sensor, const hal::RigidTransform& T_world_camera, int stride_px,
                      std::span<BulkRay> rays);
/// One ray for `stride_px` columns and rows.
[[nodiscard]] LookModel look_model(const SensorGeometry& sensor, int stride_px);

class LookCounter {
 public:
  /// `sensor` outlives this.
  explicit LookCounter(const SensorGeometry& sensor);

  /// Fills in the gains, which must be zero.
  void count(const VoxelMap& map, const LookModel& model, std::span<Look> looks, ThreadPool& pool);

 private:
  const SensorGeometry& sensor_;
  ReservedArray<std::uint32_t> seen_;  ///< a bit for each voxel of a look's box; zero between looks
};

}  // namespace g3d::mapper::cpu
