// SPDX-License-Identifier: Apache-2.0
// Where the robot is, when odometry alone is not believed: every frame is aligned to what was seen before, and what
// that says of the base is carried on by odometry until the next frame.
//
//   T_world_base now = T_world_odometry (of the last frame) * T_odometry_base now
//
// place() is of the thread that maps, the rest of any, by value; correct() of any while nobody places.
#pragma once

#include <memory>
#include <optional>

#include "hal/kobuki/base_state.hpp"
#include "hal/messages.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/submaps/chain_move.hpp"
#include "nav/planar_algebra.hpp"
#include "nav/senses.hpp"

namespace g3d::nav {

class Placing {
 public:
  /// Without options odometry is believed and every call does nothing. `card`: as for the aligner, whose mapper has
  /// finished every frame before the next is placed.
  Placing(const std::optional<mapper::align::AlignOptions>& options, const hal::CameraModel& camera,
          const hal::Pose& T_base_camera, mapper::align::FitCard* card = nullptr);

  /// Frames in their order. `sight`, which is not refused, has the poses of odometry and gets the corrected ones.
  /// `map`: of the frames before, not written to meanwhile.
  void place(const hal::Frame& frame, const mapper::VoxelMap& map, Sight& sight);
  /// The map was corrected after the last frame: so is what frames are aligned to. Takes up to some hundred
  /// milliseconds, and allocates.
  void correct(const mapper::submaps::ChainMove& move);
  /// The other part of that: where odometry stands.
  void move(const mapper::submaps::ChainMove& move);
  /// How the last frame was placed.
  [[nodiscard]] const mapper::align::AlignResult& last() const { return last_; }
  [[nodiscard]] const hal::PlanarPose& T_world_odometry() const { return T_world_odometry_; }
  /// Nothing if odometry is believed.
  [[nodiscard]] const mapper::align::Aligner* aligner() const { return aligner_.get(); }

 private:
  std::unique_ptr<mapper::align::Aligner> aligner_;
  hal::Pose T_camera_base_;
  hal::PlanarPose T_world_odometry_;
  mapper::align::AlignResult last_;
};

}  // namespace g3d::nav
