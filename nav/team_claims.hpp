// SPDX-License-Identifier: Apache-2.0
// What a chooser makes of its teammates' goals: places near them are not gone to, and what will be seen from there
// counts for nothing. Whoever claimed a place first keeps it, because nobody chooses what he knows to be claimed; where
// two have chosen at once, the lower id keeps it. And what a chooser has to offer to whoever assigns places.
// One thread. Allocates nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "nav/set_aside.hpp"
#include "nav/teammates.hpp"
#include "nav/tour_search.hpp"

namespace g3d::nav {

class TeamClaims {
 public:
  static constexpr double kApart_m = 1.0;  ///< goals nearer to each other are one place: a door, a corner
  static constexpr hal::TimeNs kClaimHolds_ns = 5'000'000'000;  ///< after the last word
  static constexpr double kAssigned_m = 0.8;  ///< a view this near to the assigned place is what was meant

  /// The latest word of all. Claims of whoever has been silent for long do not count.
  void take(const TeamSight& sight, hal::TimeNs now);
  [[nodiscard]] bool has_team() const { return has_team_; }
  [[nodiscard]] std::size_t size() const { return count_; }

  [[nodiscard]] bool is_claimed(double x_m, double y_m) const { return is_near_any(x_m, y_m, false); }
  /// By somebody who keeps it, though this robot is on its way there.
  [[nodiscard]] bool is_lost(double x_m, double y_m) const { return is_near_any(x_m, y_m, true); }

  /// A view that the robot drives to.
  struct Own {
    Cell cell;
    int first_bearing = 0;
  };
  /// Marks what teammates will see as claimed, and nothing else; what the own view shows stays the robot's unless it is
  /// lost. Casts the rays of at most one place for each claim.
  void mark(const CellGrid<CellState>& ground, TourSearch& search, SetAside& aside,
            const std::optional<Own>& own) const;

  /// The first of the views that is near what the leader wants.
  [[nodiscard]] const View* assigned(const CellGrid<CellState>& ground, const TourSearch& search,
                                     std::span<const View> views) const;
  /// The leader wants another place than this one.
  [[nodiscard]] bool wants_other_than(double x_m, double y_m) const;

 private:
  struct Claim {
    double x_m = 0.0, y_m = 0.0;
    bool is_first = false;  ///< before ours, of two that were made at once
  };
  [[nodiscard]] bool is_near_any(double x_m, double y_m, bool of_first_alone) const;
  void mark_around(const Claim& claim, const CellGrid<CellState>& ground, TourSearch& search, SetAside& aside) const;

  bool has_team_ = false;
  std::array<Claim, kMostTeammates> claims_{};
  std::size_t count_ = 0;
  std::optional<hal::PlanarPose> assigned_;
};

/// The places of a tour that are distinct, in its order.
struct TourOffers {
  std::array<Offer, kMostOffers> offers{};
  std::size_t count = 0;

  static constexpr double kDistinct_m = 1.0;
  void take(const CellGrid<CellState>& ground, const TourSearch& search, const hal::PlanarPose& robot);
};

}  // namespace g3d::nav
