// SPDX-License-Identifier: Apache-2.0
// Which goals were left for others of late. Whoever goes to and fro between two goals gets nowhere, so a goal that is
// taken up again so soon is driven to the end.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "hal/messages.hpp"
#include "hal/twist.hpp"

namespace g3d::nav {

class GoalHistory {
 public:
  static constexpr double kSame_m = 0.6;
  static constexpr hal::TimeNs kOfLate_ns = 60'000'000'000;

  /// `left` is given up for `taken` before it was reached. Returns whether `taken` was itself left of late.
  bool change(const hal::PlanarPose& left, const hal::PlanarPose& taken, hal::TimeNs now) {
    if (is_same(left, taken)) return false;
    bool was_left = false;
    for (const Entry& entry : entries_) {
      was_left = was_left || (entry.is_used && now - entry.left_ns < kOfLate_ns && is_same(entry.goal, taken));
    }
    entries_[next_] = {left, now, true};
    next_ = (next_ + 1) % entries_.size();
    return was_left;
  }

 private:
  struct Entry {
    hal::PlanarPose goal;
    hal::TimeNs left_ns = 0;
    bool is_used = false;
  };
  static bool is_same(const hal::PlanarPose& a, const hal::PlanarPose& b) {
    return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < kSame_m;
  }

  std::array<Entry, 6> entries_;
  std::size_t next_ = 0;
};

}  // namespace g3d::nav
