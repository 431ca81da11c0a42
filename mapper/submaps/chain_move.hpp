// SPDX-License-Identifier: Apache-2.0
// By how much a correction moves what was mapped at a time: the submap of that time takes it with it.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

class ChainMove {
 public:
  ChainMove() = default;
  /// `moves[i]`: of everything from `begins_ns[i]` on.
  ChainMove(std::vector<hal::TimeNs> begins_ns, std::vector<hal::Pose> moves)
      : begins_ns_(std::move(begins_ns)), moves_(std::move(moves)) {}
  /// From where the submaps stand to where they are to stand: one pose each.
  ChainMove(std::span<const Submap> submaps, std::span<const hal::Pose> T_world_stored) {
    for (std::size_t i = 0; i < submaps.size(); ++i) {
      begins_ns_.push_back(submaps[i].first_ns);
      moves_.push_back(hal::compose(T_world_stored[i], hal::inverse(submaps[i].T_world_stored)));
    }
  }

  /// Of world frames: before the correction to after it. Nothing is known of times before the first submap.
  [[nodiscard]] hal::Pose at(hal::TimeNs stamp_ns) const {
    const auto after = std::upper_bound(begins_ns_.begin(), begins_ns_.end(), stamp_ns);
    return after == begins_ns_.begin() ? hal::Pose{} : moves_[static_cast<std::size_t>(after - begins_ns_.begin()) - 1];
  }
  /// Of the robot itself.
  [[nodiscard]] hal::Pose newest() const { return moves_.empty() ? hal::Pose{} : moves_.back(); }

 private:
  std::vector<hal::TimeNs> begins_ns_;  ///< ascending
  std::vector<hal::Pose> moves_;
};

}  // namespace g3d::mapper::submaps
