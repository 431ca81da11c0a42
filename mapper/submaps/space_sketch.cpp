// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/space_sketch.hpp"

#include <algorithm>

#include "hal/frame_pool.hpp"

namespace g3d::mapper::submaps {
namespace {

int thinning_of(const hal::CameraModel& camera, int width_px) {
  return std::max(1, (camera.width_px + width_px - 1) / width_px);
}

/// Pixel (u, v) of the thinned image is pixel (thin * u, thin * v).
hal::CameraModel thinned_camera(hal::CameraModel camera, int thin) {
  const auto by = static_cast<float>(thin);
  camera.width_px = (camera.width_px + thin - 1) / thin;
  camera.height_px = (camera.height_px + thin - 1) / thin;
  camera.fx_px /= by;
  camera.fy_px /= by;
  camera.cx_px /= by;
  camera.cy_px /= by;
  return camera;
}

MapperConfig sketch_config(float resolution_m) {
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.with_colour = false;
  config.capacity = {1U << 14, 1U << 14, 8};
  return config;
}

}  // namespace

SpaceSketch::SpaceSketch(const hal::CameraModel& camera, const SketchOptions& options)
    : options_(options),
      camera_(camera),
      thin_(thinning_of(camera, options.width_px)),
      thinned_(hal::make_frame(thinned_camera(camera, thin_))) {
  for (auto& mapper : mappers_) {
    mapper = std::make_unique<Mapper>(sketch_config(options.resolution_m), thinned_camera(camera, thin_));
  }
}

void SpaceSketch::add(const hal::Frame& frame, const hal::Pose& T_world_camera) {
  if (frame.stamp_ns < due_ns_) return;
  due_ns_ = frame.stamp_ns + options_.every_ns;
  std::uint16_t* to = thinned_.depth.get();
  for (int v = 0; v < camera_.height_px; v += thin_) {
    for (int u = 0; u < camera_.width_px; u += thin_)
      *to++ = frame.depth[static_cast<std::size_t>(v * camera_.width_px + u)];
  }
  thinned_.stamp_ns = frame.stamp_ns;
  thinned_.has_colour = false;
  (void)mappers_[active_]->integrate(thinned_, T_world_camera);
}

std::unique_ptr<VoxelMap> SpaceSketch::take_ended() {
  VoxelMap& full = mappers_[1 - active_]->map();
  const std::uint32_t count = std::max<std::uint32_t>(full.block_count(), 1);
  auto own = std::make_unique<VoxelMap>(full.grid(), MapCapacity{count, count, 8});
  BlockValues values;
  for (const BlockKey key : full.sorted_keys()) {
    full.read_stored_block(key, values);
    (void)own->write_block(key, values);
  }
  full.clear();
  return own;
}

}  // namespace g3d::mapper::submaps
