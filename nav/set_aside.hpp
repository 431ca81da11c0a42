// SPDX-License-Identifier: Apache-2.0
// What has been tried in vain: targets (small squares of frontier) that stayed unknown although they were looked at, or
// that could not be reached, and places that could not be driven to. They rest for a while, longer each time, and are
// given up only after several tries. One thread; memory is sized by reset().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::nav {

class SetAside {
 public:
  enum class Cause : std::uint8_t { fruitless, blocked };

  void reset(std::size_t targets, int max_tries, double rest_s);
  /// Never to be looked at.
  void exclude(std::uint32_t target) { ignored_[target] |= kExcluded; }

  /// `weight` tries at once: what promises little is not worth coming back to.
  void target_failed(std::uint32_t target, Cause cause, hal::TimeNs now, int weight = 1);
  void place_failed(Cell place, hal::TimeNs now);
  /// Ends rests that are over.
  void expire(hal::TimeNs now);
  /// What could not be reached is tried again as if it never had been: something that was closed has opened. What was
  /// looked at in vain is not.
  void forgive_blocked();
  /// Ends all rests: nothing else is left to do. False if there were none.
  bool wake_all();

  /// Teammates see to it: not to be looked at until forget_claims().
  void claim(std::uint32_t target);
  void unclaim(std::uint32_t target) { ignored_[target] &= static_cast<std::uint8_t>(~kClaimed); }
  /// False if there were none.
  bool forget_claims();
  [[nodiscard]] bool has_claims() const { return !claimed_.empty(); }

  /// Per target: nonzero while it is not to be looked at.
  [[nodiscard]] std::span<const std::uint8_t> ignored() const { return ignored_; }
  [[nodiscard]] bool is_claimed(std::uint32_t target) const { return (ignored_[target] & kClaimed) != 0; }
  [[nodiscard]] bool is_excluded(std::uint32_t target) const { return (ignored_[target] & kExcluded) != 0; }
  [[nodiscard]] bool is_given_up(std::uint32_t target) const { return (ignored_[target] & kGivenUp) != 0; }
  [[nodiscard]] bool was_blocked(std::uint32_t target) const { return (ignored_[target] & kBlocked) != 0; }
  [[nodiscard]] bool is_place_resting(Cell place, int radius_cells) const;

 private:
  static constexpr std::uint8_t kExcluded = 1;
  static constexpr std::uint8_t kResting = 2;
  static constexpr std::uint8_t kGivenUp = 4;
  static constexpr std::uint8_t kBlocked = 8;  ///< only together with one of the others
  static constexpr std::uint8_t kClaimed = 16;
  static constexpr std::uint8_t kNotOurs = kExcluded | kClaimed;

  struct RestingTarget {
    std::uint32_t target = 0;
    hal::TimeNs until = 0;
  };
  struct RestingPlace {
    Cell cell;
    hal::TimeNs until = 0;
    int tries = 0;
  };
  static constexpr std::size_t kMaxPlaces = 128;

  int max_tries_ = 3;
  hal::TimeNs rest_ns_ = 0;
  std::vector<std::uint8_t> ignored_;
  std::vector<std::uint8_t> tries_;
  std::vector<RestingTarget> resting_;
  std::vector<std::uint32_t> claimed_;  ///< targets
  std::array<RestingPlace, kMaxPlaces> places_{};
  std::size_t place_count_ = 0;
};

}  // namespace g3d::nav
