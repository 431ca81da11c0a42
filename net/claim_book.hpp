// SPDX-License-Identifier: Apache-2.0
// Whose claims of places count. Everybody claims where it goes before it knows who else does: of claims that are too
// near to each other one stands, the same for all who know them: that of the lower id. Claims of robots that are not
// heard of any more are not noted, so what they had claimed is free. One thread; allocates nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "hal/twist.hpp"
#include "net/layer_id.hpp"
#include "net/robot_status.hpp"

namespace g3d::net {

struct Claim {
  RobotId robot = 0;
  hal::PlanarPose place;
  bool stands = false;  ///< after settle()
};

[[nodiscard]] inline double apart_m(const hal::PlanarPose& a, const hal::PlanarPose& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

class ClaimBook {
 public:
  void clear() { count_ = 0; }
  /// One for each robot. What is too much is left out.
  void note(const Claim& claim) {
    if (count_ < claims_.size()) claims_[count_++] = claim;
  }
  /// Of claims nearer than `same_m` one stands.
  void settle(double same_m) {
    std::sort(claims_.begin(), claims_.begin() + static_cast<std::ptrdiff_t>(count_),
              [](const Claim& a, const Claim& b) { return a.robot < b.robot; });
    for (std::size_t i = 0; i < count_; ++i) {
      claims_[i].stands = std::none_of(
          claims_.begin(), claims_.begin() + static_cast<std::ptrdiff_t>(i),
          [&](const Claim& before) { return before.stands && apart_m(before.place, claims_[i].place) < same_m; });
    }
  }
  [[nodiscard]] bool stands(RobotId robot) const {
    return std::any_of(all().begin(), all().end(), [&](const Claim& c) { return c.robot == robot && c.stands; });
  }
  [[nodiscard]] std::span<const Claim> all() const { return {claims_.data(), count_}; }

 private:
  std::array<Claim, kMostHeard + 1> claims_{};
  std::size_t count_ = 0;
};

}  // namespace g3d::net
