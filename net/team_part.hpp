// SPDX-License-Identifier: Apache-2.0
// A robot with threads as a member of its team: what its navigator says goes into its layer, and what the others say
// comes back to it, turned from the world's frame into that of its own map.
//
//   navigator ══word══▶ TeamPart ──▶ TeamTalk ──▶ own layer;   others' layers ──▶ TeamTalk ──▶ TeamPart ══sight══▶
//   navigator
//
// Thread: the one that gossips. Allocates at its first round.
#pragma once

#include <memory>

#include "hal/latest.hpp"
#include "nav/live_status.hpp"
#include "nav/team_link.hpp"
#include "net/map_sharing.hpp"
#include "net/team_talk.hpp"

namespace g3d::net {

class TeamPart {
 public:
  /// Both outlive this. `radius_m`: of the robot's body.
  TeamPart(nav::TeamLink& link, const hal::Latest<nav::LiveStatus>& status, float radius_m)
      : link_(link), status_(status), radius_m_(radius_m) {}

  /// After every round of `sharing`, which is always the same one. Says nothing before the navigator has.
  void on_round(MapSharing& sharing, hal::TimeNs now_ns);
  /// Nothing before the first word.
  [[nodiscard]] const TeamTalk* talk() const { return talk_.get(); }

 private:
  [[nodiscard]] StateWord state(const MapSharing& sharing) const;

  nav::TeamLink& link_;
  const hal::Latest<nav::LiveStatus>& status_;
  float radius_m_;
  std::unique_ptr<TeamTalk> talk_;
  nav::TeamWord word_;
  std::uint64_t seen_words_ = 0;
};

}  // namespace g3d::net
