// SPDX-License-Identifier: Apache-2.0
// What becomes a submap: all that was mapped on a stretch of the way. It is noted frame by frame which blocks of the
// view have changed; at the end of the stretch they are copied out, so that the next one can begin at once and whoever
// makes a submap of them needs the view no more. Thread: the view's writer, but for is_noted(). After construction
// nothing allocates.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/align/surface_map.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper::submaps {

struct ChainOptions {
  double most_way_m = 4.0;  ///< a submap is finished after so much driving ...
  double most_turn_rad = 6.3;
  double most_s = 30.0;  ///< ... or time
};

struct Stretch {
  /// With room for all of that map.
  explicit Stretch(const VoxelMap& view);
  void clear();

  hal::TimeNs first_ns = 0;
  hal::TimeNs last_ns = 0;
  hal::TimeNs anchor_ns = 0;  ///< when the camera was there
  hal::Pose T_world_anchor;   ///< the camera half-way
  double way_m = 0.0;         ///< from the anchor before to this one
  double turn_rad = 0.0;      ///< the same, all turns added up
  double held_s = 0.0;        ///< the same, time in which odometry alone knew the way
  VoxelMap blocks;            ///< stored codes of those that have changed
  std::unique_ptr<align::SurfaceMap> surfaces;
};

class StretchRecorder {
 public:
  /// `view` outlives this.
  StretchRecorder(const VoxelMap& view, const ChainOptions& options);

  /// After every frame, with the slots of the view that it has changed. True: time to end the stretch.
  /// `samples`: the surfaces that it shows, camera frame. `is_held`: its step is odometry's, at least in part.
  bool add_frame(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera, std::span<const std::uint32_t> changed_slots,
                 std::span<const align::DepthSample> samples, bool is_held);
  /// Ends it. `into` was cleared. False, and nothing happens, if there was no frame since the last one.
  bool take(Stretch& into);
  [[nodiscard]] bool is_empty() const { return passed_.empty(); }
  /// Whether a block of the view has changed since the last stretch, or was known before the first frame: nobody else
  /// knows it. Any thread.
  [[nodiscard]] bool is_noted(std::uint32_t slot) const {
    return !has_begun_.load(std::memory_order_acquire) || is_noted_[slot].load(std::memory_order_relaxed);
  }

 private:
  void note(std::uint32_t slot);

  struct Passed {
    hal::TimeNs stamp_ns;
    hal::Pose T_world_camera;
    double way_m;
    double turn_rad;
    double held_s;
  };

  const VoxelMap& view_;
  ChainOptions options_;
  std::vector<std::uint32_t> changed_slots_;
  std::vector<std::atomic<bool>> is_noted_;  ///< by slot
  std::unique_ptr<align::SurfaceMap> surfaces_;
  std::atomic<bool> has_begun_{false};
  std::vector<Passed> passed_;  ///< frames of this stretch
  hal::Pose last_camera_;
  hal::TimeNs last_ns_ = 0;
  double way_m_ = 0.0;  ///< since the last anchor
  double turn_rad_ = 0.0;
  double held_s_ = 0.0;
  double way_at_end_m_ = 0.0;  ///< of the last stretch
  double turn_at_end_rad_ = 0.0;
};

}  // namespace g3d::mapper::submaps
