// SPDX-License-Identifier: Apache-2.0
#include "tests/support/free_space_run.hpp"

#include <cmath>

#include "mapper/map_hash.hpp"

namespace g3d::test {

using namespace mapper;
using namespace mapper::cpu;

std::string hash_of_run(FreeSpace& free_space, const Kernels& kernels, const MapperConfig& config,
                        const Workload& work) {
  const SensorGeometry sensor(work.camera, config.resolution_m, config.near_m, config.far_m);
  const float mask_raw = std::nearbyint(config.mask_depth_m * work.camera.depth_units_per_metre);
  VoxelMap map(Grid{config.resolution_m}, config.capacity);
  ThreadPool pool(config.threads);
  RayEnds ends(sensor, {}, static_cast<std::uint16_t>(mask_raw), config.carve_invalid);
  DepthPyramid pyramid(work.camera.width_px, work.camera.height_px);
  HitScatter hits(sensor);
  BlockUpdater updater(map, sensor, config.steps);
  std::uint32_t number = 0;
  for (const auto& [frame, pose] : work.frames) {
    const auto geometry = frame_geometry(sensor, hal::to_transform(pose));
    if (!geometry) return "out of range";
    ends.compute(frame.depth.get(), kernels, pool);
    hits.clear();
    hits.compute(*geometry, ends, frame.rgb.get(), kernels, pool);
    pyramid.compute(ends, kernels, pool);
    free_space.offer({sensor, *geometry, ends, pyramid, hits, updater, kernels, pool, true, ++number});
    for (int s = 0; s < HitScatter::kShards; ++s) {
      for (const std::uint32_t index : hits.shard(s)) {
        HitRecord& record = hits.record(index);
        if (record.consumed == 0)
          updater.offer_hits(updater.chunks() - 1, geometry->block_key(record.block_id), record);
      }
    }
    updater.finish(pool);
  }
  return map_hash(map);
}

}  // namespace g3d::test
