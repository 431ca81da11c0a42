// SPDX-License-Identifier: Apache-2.0
// What one submap's own frames say about space, in coarse voxels: where it saw free space and where it did not look.
// The view cannot tell, since it holds what earlier frames have said there, at places that have drifted since. Every
// few pixels of every few frames are enough. Thread: one; take_ended() may be another's. Taking allocates.
#pragma once

#include <array>
#include <cstddef>
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
  /// What is added from now on belongs to the next sketch. Allocates nothing. Not before the one that was ended last
  /// was taken.
  void end() { active_ = 1 - active_; }
  /// The one that was ended, as a map of its own.
  [[nodiscard]] std::unique_ptr<VoxelMap> take_ended();
  /// All that was added since the last time.
  [[nodiscard]] std::unique_ptr<VoxelMap> take() {
    end();
    return take_ended();
  }

 private:
  SketchOptions options_;
  hal::CameraModel camera_;
  int thin_;
  hal::Frame thinned_;
  std::array<std::unique_ptr<Mapper>, 2> mappers_;
  std::size_t active_ = 0;
  hal::TimeNs due_ns_ = 0;
};

}  // namespace g3d::mapper::submaps
