// SPDX-License-Identifier: Apache-2.0
// Where the bodies of teammates are, going by their own words: carried forward along the way that each has told, the
// less surely the older the word is. Whoever has not said anything for some seconds is taken to stand where he was last
// heard of, until the camera looks through that place; then he is gone from there, and nobody knows where to.
// One thread. Allocates nothing.
#pragma once

#include <array>
#include <cstddef>

#include "hal/messages.hpp"
#include "nav/path_smoothing.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

/// A word older than this says where the body was, and no more where it is going.
inline constexpr double kTeamWordFresh_s = 3.0;

[[nodiscard]] bool is_fresh(const Teammate& mate, hal::TimeNs now);
/// It drives, or means to as soon as nobody stands in its way: it has told of a way.
[[nodiscard]] bool is_under_way(const Teammate& mate, hal::TimeNs now);
/// Where it will be at `when`, which may be `now`: on its way, which one who stands begins now.
[[nodiscard]] Waypoint place_at(const Teammate& mate, hal::TimeNs now, hal::TimeNs when);
/// So far from place_at(mate, now, now) it may be.
[[nodiscard]] double doubt_m(const Teammate& mate, hal::TimeNs now);

class TeamBodies {
 public:
  /// The latest word of all. A mate that is silent keeps its place here, unless it has been seen to be gone.
  void take(const TeamSight& sight) {
    sight_ = sight;
    is_gone_ = {};
  }
  [[nodiscard]] const TeamSight& sight() const { return sight_; }
  [[nodiscard]] bool empty() const { return sight_.count == 0; }
  /// Calls `looked_through_ns(x_m, y_m)` for the silent ones: when the camera last looked through there. Whoever is
  /// not where he was is taken off.
  template <typename Looked>
  void forget_gone(hal::TimeNs now, Looked&& looked_through_ns) {
    for (std::size_t i = 0; i < sight_.count; ++i) {
      const Teammate& mate = sight_.mates[i];
      if (is_fresh(mate, now)) continue;
      is_gone_[i] = looked_through_ns(mate.T_world_base.x_m, mate.T_world_base.y_m) > mate.told_ns + kLookedAfter_ns;
    }
  }

  /// Once per step: what lies around `T_world_base` is looked up from then on.
  void look_around(const hal::PlanarPose& T_world_base, hal::TimeNs now);
  /// A body is here, or will be within kAhead_s; near the last look_around() alone.
  [[nodiscard]] bool may_be_at(double x_m, double y_m) const {
    for (std::size_t i = 0; i < disc_count_; ++i) {
      const double dx = x_m - discs_[i].x_m;
      const double dy = y_m - discs_[i].y_m;
      if (dx * dx + dy * dy <= discs_[i].square_m2) return true;
    }
    return false;
  }
  /// A body is within `gap_m` of here: what is felt or seen there is a robot, not the building.
  [[nodiscard]] bool is_near(double x_m, double y_m, double gap_m, hal::TimeNs now) const;

  /// The same of those alone who have spoken lately: what is seen there needs no other explanation.
  [[nodiscard]] bool is_known_at(double x_m, double y_m, double gap_m, hal::TimeNs now) const;

  /// Bodies that stay where they are, as far as anybody knows: visit(x_m, y_m, radius_m), doubt included.
  template <typename Visit>
  void for_standing(hal::TimeNs now, Visit&& visit) const {
    for (std::size_t i = 0; i < sight_.count; ++i) {
      const Teammate& mate = sight_.mates[i];
      const bool is_silent = !is_fresh(mate, now);
      if ((is_silent && is_gone_[i]) || (!is_silent && mate.is_moving)) continue;
      visit(mate.T_world_base.x_m, mate.T_world_base.y_m, static_cast<double>(mate.radius_m) + kDoubtStanding_m);
    }
  }

  static constexpr double kAhead_s = 0.8;
  static constexpr double kDoubtStanding_m = 0.03;

 private:
  static constexpr hal::TimeNs kLookedAfter_ns = 500'000'000;
  static constexpr double kAround_m = 2.5;
  static constexpr std::size_t kMostSteps = 10;  ///< discs that a body's next way is made of

  [[nodiscard]] bool is_at(const Teammate& mate, double x_m, double y_m, double gap_m, hal::TimeNs now) const;

  struct Disc {
    double x_m = 0.0, y_m = 0.0;
    double square_m2 = 0.0;  ///< of the radius
  };

  TeamSight sight_;
  std::array<bool, kMostTeammates> is_gone_{};
  std::array<Disc, kMostTeammates * kMostSteps> discs_{};
  std::size_t disc_count_ = 0;
};

}  // namespace g3d::nav
