// SPDX-License-Identifier: Apache-2.0
// Who goes first where the ways of robots meet: the one with the lower id. Both know that rule and each other's way, so
// nothing has to be agreed on. The other one drives on if it is through before they meet, else it waits where the first
// one does not come by, and makes room if it stands right in that way. Nobody drives into a body that stands, whoever
// it is.
// A pure function of what is told; allocates nothing.
#pragma once

#include <cstddef>
#include <cstdint>

#include "hal/messages.hpp"
#include "nav/path_track.hpp"
#include "nav/teammates.hpp"

namespace g3d::nav {

struct RightOfWayConfig {
  double body_radius_m = 0.18;
  double speed_mps = 0.35;    ///< at which it drives its path, on average
  double look_s = 8.0;        ///< how far ahead ways are compared
  double gap_m = 0.12;        ///< between bodies that both move
  double pass_gap_m = 0.10;   ///< between one that waits and the one that passes
  double early_s = 1.0;       ///< so much earlier than told a mate may come by,
  double late_s = 1.5;        ///< or later
  double room_s = 5.0;        ///< whoever stands in the way makes room so long before the first one comes
  double queue_gap_m = 0.45;  ///< kept to a body that stands in the way
  double stand_look_m = 2.5;  ///< of the path, looked at for standing bodies
};

struct Passage {
  enum class Kind : std::uint8_t {
    free,
    hold,       ///< it may drive on for within_m, and waits there
    make_room,  ///< it stands in the way of one who goes first
  };
  Kind kind = Kind::free;
  double within_m = 0.0;
  std::uint64_t robot = 0;   ///< whom it waits for
  bool is_yielding = false;  ///< to one who goes first; else somebody stands there
};

class RightOfWay {
 public:
  explicit RightOfWay(const RightOfWayConfig& config) : config_(config) {}

  /// `track`: what it drives, from where it is; empty: it stays. `first_turn_s`: it turns for so long before it drives.
  [[nodiscard]] Passage judge(const TeamSight& sight, hal::TimeNs now, const hal::PlanarPose& T_world_base,
                              const PathTrack& track, double first_turn_s) const;
  /// Whoever goes before this robot, is under way and may come near within the next minute; at most kMostTeammates.
  [[nodiscard]] static bool goes_first(const TeamSight& sight, const Teammate& mate, hal::TimeNs now);
  [[nodiscard]] const RightOfWayConfig& config() const { return config_; }

 private:
  [[nodiscard]] Passage yield(const Teammate& mate, hal::TimeNs now, const hal::PlanarPose& T_world_base,
                              const PathTrack& track, double first_turn_s) const;
  [[nodiscard]] Passage queue(const Teammate& mate, hal::TimeNs now, const hal::PlanarPose& T_world_base,
                              const PathTrack& track) const;

  RightOfWayConfig config_;
};

}  // namespace g3d::nav
