// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/join_old.hpp"

#include <limits>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

/// How far the next one stands from where it stood when it was finished, seen from this one.
double disagreement(const Submap& one, const Submap& next, const JoinRule& rule) {
  const hal::Pose as_one = hal::compose(one.T_world_stored, next.T_stored_anchor);
  const align::Vector6 apart = align::difference(as_one, next.T_world_anchor());
  return align::shift_of(apart) / rule.apart_m + align::turn_of(apart) / rule.apart_rad;
}

}  // namespace

std::optional<std::size_t> choose_join(std::span<const Submap> submaps, const JoinRule& rule) {
  if (submaps.size() <= rule.most_submaps || submaps.size() < rule.newest + 2) return std::nullopt;
  std::size_t best = 0;
  double best_price = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 + rule.newest < submaps.size(); ++i) {
    const auto size = static_cast<double>(submaps[i].stations.size() + submaps[i + 1].stations.size());
    const double price = size + disagreement(submaps[i], submaps[i + 1], rule);
    if (price >= best_price) continue;
    best = i;
    best_price = price;
  }
  return best;
}

void join_old(SubmapChain& chain, LoopCloser& closer, const JoinRule& rule) {
  while (const auto one = choose_join(chain.submaps(), rule)) {
    const hal::Pose T_next_one = chain.join(*one);
    closer.join(static_cast<std::uint32_t>(*one), T_next_one);
  }
}

}  // namespace g3d::mapper::submaps
