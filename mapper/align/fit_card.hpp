// SPDX-License-Identifier: Apache-2.0
// Whoever fits frames to surfaces elsewhere, bit by bit as fit() and SurfaceMap do: a graphics card. It may be lost at
// any time; `mirror` then holds all that it knew, and the CPU goes on from there. Thread: that of the aligner.
#pragma once

#include <cstdint>

#include "hal/messages.hpp"
#include "mapper/align/depth_sample.hpp"
#include "mapper/align/pose_fit.hpp"
#include "mapper/align/surface_map.hpp"

namespace g3d::mapper::align {

struct CardFit {
  std::uint32_t chosen = 0;  ///< samples
  FitAnswer answer;
};

class FitCard {
 public:
  virtual ~FitCard() = default;
  /// The mirror was changed by others than add(): the card is to have it anew.
  virtual void forget_surfaces() = 0;
  /// The frame's samples, fitted. False: there is no card, or it was lost now.
  [[nodiscard]] virtual bool fit(const hal::Frame& frame, const SampleShape& shape, const SurfaceMap& mirror,
                                 const FitQuestion& question, CardFit& fitted) = 0;
  /// After fit() returned true: adds the samples where the frame is now, there and in the mirror. `looks_at_map`: as
  /// for SurfaceMap::add() with the map as it is before the frame, and forget_gone(). False: it was lost, and the
  /// mirror is what it was.
  [[nodiscard]] virtual bool add(const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns, bool looks_at_map,
                                 SurfaceMap& mirror) = 0;
};

}  // namespace g3d::mapper::align
