// SPDX-License-Identifier: Apache-2.0
// What one submap's own frames say about space, in coarse voxels: where it saw free space and where it did not look.
// The view cannot tell, since it holds what earlier frames have said there, at places that have drifted since. Every
// few pixels of every few frames are enough. Thread: one. take() allocates.
#pragma once

#include <memory>

#include "mapper/mapper.hpp"

namespace g3d::mapper::submaps {

struct SketchOptions {
  float resolution_m = 0.1F;
  int width_px = 80;  ///< of the thinned images, at most
  hal::TimeNs every_ns = 150'000'000;
};

class SpaceSketch {
 public:
  explicit SpaceSketch(const hal::CameraModel& camera, const SketchOptions& options = {});

  void add(const hal::Frame& frame, const hal::Pose& T_world_camera);
  /// All that was added since the last time, as a map of its own.
  [[nodiscard]] std::unique_ptr<VoxelMap> take();

 private:
  SketchOptions options_;
  hal::CameraModel camera_;
  int thin_;
  hal::Frame thinned_;
  Mapper mapper_;
  hal::TimeNs due_ns_ = 0;
};

}  // namespace g3d::mapper::submaps
