// SPDX-License-Identifier: Apache-2.0
#include "nav/placing.hpp"

namespace g3d::nav {

Placing::Placing(const std::optional<mapper::align::AlignOptions>& options, const hal::CameraModel& camera,
                 const hal::Pose& T_base_camera, mapper::align::FitCard* card)
    : aligner_(options ? std::make_unique<mapper::align::Aligner>(*options, camera, card) : nullptr),
      T_camera_base_(hal::inverse(T_base_camera)) {}

void Placing::place(const hal::Frame& frame, const mapper::VoxelMap& map, Sight& sight) {
  if (aligner_ == nullptr) return;
  const mapper::align::SeenSpace space(map);
  last_ = aligner_->align(frame, sight.T_world_camera, &space);
  sight.T_world_camera = last_.T_world_camera;
  const hal::PlanarPose T_world_base = on_plane(hal::compose(sight.T_world_camera, T_camera_base_));
  T_world_odometry_ = compose(T_world_base, inverse(sight.T_world_base));
  sight.T_world_base = T_world_base;
}

void Placing::correct(const mapper::submaps::ChainMove& move) {
  if (aligner_ == nullptr) return;
  aligner_->correct(move.newest(), [&](hal::TimeNs born_ns) { return move.at(born_ns); });
}

void Placing::move(const mapper::submaps::ChainMove& move) {
  if (aligner_ != nullptr) T_world_odometry_ = compose(on_plane(move.newest()), T_world_odometry_);
}

}  // namespace g3d::nav
