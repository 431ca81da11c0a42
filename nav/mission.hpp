// SPDX-License-Identifier: Apache-2.0
// What the robot is about, as one table of states and events. A person's word (pause, resume, stop, come home) counts
// in every state; what is not in the table changes nothing.
//
//   starting --looked_around--> exploring --explored / battery_low / come_home--> returning --at_home--> home
//                               exploring <----------------more_to_see----------- returning
//       any of these three <--pause / resume--> paused,  --lost / resume--> needs_help,  --stop / resume--> stopped
#pragma once

#include <cstdint>
#include <string_view>

namespace g3d::nav {

enum class MissionState : std::uint8_t {
  starting,  ///< the first look around
  exploring,
  returning,   ///< on the way home
  home,        ///< done
  paused,      ///< stands until resumed
  stopped,     ///< the same, but for good if nobody resumes
  needs_help,  ///< it has tried everything and cannot move to where it wants
};

enum class MissionEvent : std::uint8_t {
  looked_around,
  explored,     ///< every frontier left is explained
  battery_low,  ///< what is left is needed for the way home
  come_home,
  at_home,
  no_way_home,  ///< exploration is over and home cannot be reached
  more_to_see,  ///< on the way home: teammates have found what is worth another look
  lost,         ///< no goal can be reached any more
  pause,
  resume,
  stop,
};

[[nodiscard]] std::string_view name_of(MissionState state);

class Mission {
 public:
  /// Returns whether the state changed.
  bool apply(MissionEvent event);
  [[nodiscard]] MissionState state() const { return state_; }
  /// In the three states in which wheels may turn.
  [[nodiscard]] bool is_driving() const;
  [[nodiscard]] bool is_over() const { return state_ == MissionState::home; }
  /// While held (paused, stopped, needs help): what resume goes back to. Else the state itself.
  [[nodiscard]] MissionState purpose() const { return is_driving() || is_over() ? state_ : held_; }

 private:
  MissionState state_ = MissionState::starting;
  MissionState held_ = MissionState::starting;
};

}  // namespace g3d::nav
