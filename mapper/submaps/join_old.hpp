// SPDX-License-Identifier: Apache-2.0
// Keeps the number of submaps bounded, and with it memory and the time that a search takes: beyond it, one that is old
// becomes part of the one before. First those that agree, which no correction has moved against each other; among them
// those that cover little. Thread: the one that looks for loops, before it does.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "mapper/submaps/loop_closer.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

struct JoinRule {
  std::size_t most_submaps = 64;
  std::size_t newest = 8;  ///< are left as they are
  /// What a disagreement weighs: so much as one more submap in the joined one.
  double apart_m = 0.02;
  double apart_rad = 0.004;
};

/// The first of the two to be joined; none while there are few enough.
[[nodiscard]] std::optional<std::size_t> choose_join(std::span<const Submap> submaps, const JoinRule& rule);
/// Until they are few enough. `closer` knows all of them but perhaps the newest.
void join_old(SubmapChain& chain, LoopCloser& closer, const JoinRule& rule);

}  // namespace g3d::mapper::submaps
