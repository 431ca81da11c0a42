// SPDX-License-Identifier: Apache-2.0
// One frame of a simulated Kinect from any pose at any time: a world, a ray caster and the noise model together.
#pragma once

#include <cstdint>
#include <memory>

#include "hal/messages.hpp"
#include "hal/sim/kinect_noise.hpp"
#include "hal/sim/ray_caster.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

struct SimRendererOptions {
  CameraModel camera;
  bool noise = true;
  std::uint64_t seed = 1;
  int threads = 1;  ///< 1..64, the caller included; the images do not depend on it
};

class SimRenderer {
 public:
  SimRenderer(World world, const SimRendererOptions& options);
  /// Several cameras in one world.
  SimRenderer(std::shared_ptr<const World> world, const SimRendererOptions& options);

  /// Fills `out` (storage sized for the camera), stamp and sequence included. The sequence also picks the noise.
  /// Allocates nothing. One thread at a time.
  void render(const Pose& T_world_camera, TimeNs time_ns, std::uint64_t sequence, Frame& out);
  /// The same with every mover where the caller says, and one of them (-1: none) not drawn.
  void render(const Pose& T_world_camera, TimeNs time_ns, std::uint64_t sequence, MoverPlaces places_m,
              std::int32_t hidden, Frame& out);

  [[nodiscard]] const CameraModel& camera() const { return options_.camera; }
  [[nodiscard]] const World& world() const { return *world_; }
  /// The exact images behind the last frame.
  [[nodiscard]] const ExactView& exact() const { return view_; }

 private:
  void finish(TimeNs time_ns, std::uint64_t sequence, Frame& out);

  std::shared_ptr<const World> world_;  ///< the caster keeps a reference
  SimRendererOptions options_;
  RayCaster caster_;
  KinectNoise noise_;
  ExactView view_;
};

}  // namespace g3d::hal
