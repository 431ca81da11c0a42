// SPDX-License-Identifier: Apache-2.0
// What a Kinect 360 makes of exact depth. In this order: no reading where the projector's light does not arrive (shadow
// beside near things), where the material swallows it, too near, too far, at grazing angles, at ragged depth edges, and
// here and there at random; else range noise (Nguyen, Izadi and Lovell 2012), then the steps of 1/8 pixel disparity.
// Chance is a hash of (seed, frame, pixel), so an image is the same on every machine and for any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/ray_caster.hpp"

namespace g3d::hal {

struct KinectNoiseModel {
  float near_m = 0.5F;                ///< nearer surfaces give no reading
  float far_m = 8.0F;                 ///< farther ones neither
  float baseline_m = 0.075F;          ///< from the infrared camera to the projector, which stands to its right
  float disparity_focal_px = 580.0F;  ///< of the sensor, whatever size the image has
  float sigma_0_m = 0.0012F;          ///< sigma(z) = sigma_0 + sigma_2 (z - sigma_from)^2
  float sigma_2_perm = 0.0019F;
  float sigma_from_m = 0.4F;
  float grazing_none_cos = 0.05F;  ///< at this cosine of incidence and below: no reading
  float grazing_all_cos = 0.11F;   ///< from here on all readings; linear chance between
  float edge_fraction = 0.08F;     ///< neighbours that differ by this fraction of depth make an edge
  float edge_dropout = 0.30F;      ///< chance of no reading at an edge
  float edge_wander = 0.25F;       ///< else: chance of the reading that a neighbour should have
  float edge_focal_px =
      525.0F;  ///< of the images that this is true of; in coarser ones fewer pixels are so near an edge
  float speckle_dropout = 0.005F;  ///< chance of no reading anywhere
};

class KinectNoise {
 public:
  KinectNoise(const CameraModel& camera, std::uint64_t seed, const KinectNoiseModel& model = {});

  /// Raw depth of one frame into `depth` (pixel_count values). Allocates nothing; rows are shared among `workers`.
  void apply(const ExactView& exact, std::uint64_t frame_number, RowWorkers& workers, std::uint16_t* depth) const;

 private:
  static constexpr std::size_t kDisparitySteps = 2048;

  void apply_row(const ExactView& exact, std::uint64_t frame_key, std::size_t row, std::uint16_t* depth) const;
  [[nodiscard]] bool is_dropped(float z_m, std::uint8_t surface, std::uint32_t chance) const;

  CameraModel camera_;
  KinectNoiseModel model_;
  std::uint64_t seed_;
  float edge_share_;  ///< of the pixels beside an edge: those of the sensor's own pixels that touch it
  std::vector<std::uint16_t> raw_of_step_;  ///< reading for a disparity in eighths of a pixel
};

/// Exact depth rounded to raw units; 0 where there is nothing or where it does not fit.
void write_exact_depth(const ExactView& exact, const CameraModel& camera, std::uint16_t* depth);

}  // namespace g3d::hal
