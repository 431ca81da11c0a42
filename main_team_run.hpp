// SPDX-License-Identifier: Apache-2.0
// Robots that explore one simulated building together, in lockstep: what the bases say, frames that are due, and a
// simulated radio by which they share their maps and divide the work.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "hal/clock.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_explore.hpp"
#include "main_robot.hpp"
#include "nav/coverage.hpp"
#include "nav/robot.hpp"
#include "net/map_sharing.hpp"
#include "net/sim_radio.hpp"
#include "net/team_talk.hpp"
#include "net/team_trouble.hpp"

namespace g3d {

/// Submaps of a robot, at most; see JoinRule, and one that is ahead of them.
inline constexpr std::size_t kTeamSubmaps = 80;

class Team {
 public:
  Team(hal::SimBuilding& building, const std::vector<nav::RobotConfig>& configs, const SimOptions& options,
       net::TeamTrouble trouble, const hal::Observable& observable, double rate_hz);

  void run(hal::TimeNs limit_ns, bool show_progress);

  struct Member final : net::Link {
    Member(Team& of, std::uint32_t its_number, const nav::RobotConfig& config, hal::Clock& clock,
           const SimOptions& options);
    static net::SharingOptions sharing_options(const nav::RobotConfig& config, const SimOptions& options,
                                               std::uint32_t number);
    /// What it tells of itself beside what its navigator says.
    [[nodiscard]] net::StateWord state() const;
    [[nodiscard]] bool is_alive() const { return died_ns == 0; }
    /// Nothing more is to be expected of it.
    [[nodiscard]] bool is_through() const { return !is_alive() || robot.navigator().mission().is_over(); }
    bool send(net::Address to, mapper::ByteSpan message) override;
    Team& team;
    std::uint32_t number;
    nav::Robot robot;
    net::MapSharing sharing;
    net::TeamTalk talk;
    PlaceError place_error;
    std::vector<hal::StampedPose> way;
    std::uint64_t frames = 0;
    hal::TimeNs next_frame_ns = 0;
    hal::TimeNs home_ns = 0;
    hal::TimeNs died_ns = 0;  ///< 0: it lives
    double fraction = 0.0;
  };
  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] Member& member(std::size_t i) { return *members_[i]; }
  [[nodiscard]] hal::TimeNs now_ns() const { return now_ns_; }
  [[nodiscard]] hal::TimeNs driving_ns() const { return driving_ns_; }
  [[nodiscard]] hal::TimeNs settle_ns() const { return settle_ns_; }
  [[nodiscard]] hal::SimBuilding& building() { return building_; }
  [[nodiscard]] const net::SimRadio& radio() const { return radio_; }
  /// That live.
  [[nodiscard]] bool all_hold_the_same() const;

 private:
  [[nodiscard]] double distance_m(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] bool all_are_home() const;

  /// What was put right at the end is published.
  [[nodiscard]] bool all_have_told() const;

  /// 20 ms: what the bases say, frames that are due, and the radio.
  void advance();
  void take_frame(Member& member);
  void sample();
  void show(hal::TimeNs start_ns) const;

  hal::SimBuilding& building_;
  net::TeamTrouble trouble_;
  nav::CoverageMeter coverage_;
  hal::RealClock clock_;
  hal::Frame frame_;
  hal::TimeNs frame_period_ns_;
  hal::TimeNs now_ns_ = 0;
  hal::TimeNs driving_ns_ = 0;
  hal::TimeNs settle_ns_ = 0;
  net::SimRadio radio_;
  std::vector<std::unique_ptr<Member>> members_;
};

}  // namespace g3d
