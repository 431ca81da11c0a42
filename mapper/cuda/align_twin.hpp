// SPDX-License-Identifier: Apache-2.0
// The surfaces in a card and their mirror, the aligner's own, kept equal: the card gets all of the mirror once, then
// each changes what the other does. The mirror changes only when a frame's cells are wholly there. Thread: mapper
// thread.
#pragma once

#include "mapper/align/fit_card.hpp"
#include "mapper/cuda/card.hpp"

namespace g3d::mapper::cuda {

class AlignTwin {
 public:
  /// Another card, or none: it knows nothing yet.
  void forget_card() { is_there_ = false; }
  /// Whether this card could do it at all.
  [[nodiscard]] static bool can(Card& card, const align::SampleShape& shape, const align::SurfaceMap& mirror,
                                const align::FitQuestion& question);

  // See align::FitCard. False: the card is lost.
  [[nodiscard]] bool fit(Card& card, const hal::Frame& frame, const align::SampleShape& shape,
                         const align::SurfaceMap& mirror, const align::FitQuestion& question, align::CardFit& fitted);
  /// The card's map is that of the frame before.
  [[nodiscard]] bool add(Card& card, const hal::RigidTransform& T_world_camera, hal::TimeNs stamp_ns, bool looks_at_map,
                         float resolution_m, align::SurfaceMap& mirror);

 private:
  [[nodiscard]] static bool send(Card& card, const align::SurfaceMap& mirror);
  [[nodiscard]] static bool is_sane(const AlignState& state, const align::FitQuestion& question);

  bool is_there_ = false;
};

}  // namespace g3d::mapper::cuda
