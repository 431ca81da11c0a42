// SPDX-License-Identifier: Apache-2.0
// A team without maps or walls: robots that gossip over a simulated radio, drive straight to places, and take one off
// the list when they are there. Each goes where it was ordered to, else to the nearest place that nobody claims. For
// tests of what they agree on.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "net/team_talk.hpp"
#include "tests/support/gossip_fleet.hpp"

namespace g3d::tests {

struct TeamFleetOptions {
  FleetOptions fleet;
  net::TeamTalkOptions talk;
  int places = 12;  ///< in a square, by chance
  double extent_m = 20.0;
  double speed_mps = 0.4;
};

class TeamFleet {
 public:
  explicit TeamFleet(const TeamFleetOptions& options);

  void run(hal::TimeNs duration_ns);
  void step();
  void kill(std::uint32_t i);
  void start(std::uint32_t i);

  [[nodiscard]] GossipFleet& fleet() { return fleet_; }
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(bodies_.size()); }
  [[nodiscard]] net::TeamTalk& talk(std::uint32_t i) { return *talks_[i]; }
  [[nodiscard]] const net::TeamTalk& talk(std::uint32_t i) const { return *talks_[i]; }
  [[nodiscard]] bool is_alive(std::uint32_t i) const { return talks_[i] != nullptr; }
  /// What the robot says of itself.
  [[nodiscard]] const nav::TeamWord& word(std::uint32_t i) const { return words_[i]; }
  [[nodiscard]] int open_places() const;
  /// Of all living robots that hear each other: each knows the others and all follow one of them.
  [[nodiscard]] bool is_settled() const;
  /// Two that have stood on one place at a time.
  [[nodiscard]] int shared_places() const { return shared_places_; }
  /// Whether robot `i` still respects a claim of `other`.
  [[nodiscard]] bool respects(std::uint32_t i, net::RobotId other) const;

 private:
  struct Place {
    hal::PlanarPose at;
    bool is_open = true;
  };
  void think(std::uint32_t i);
  void drive(std::uint32_t i, double seconds);

  TeamFleetOptions options_;
  GossipFleet fleet_;
  std::vector<Place> places_;
  std::vector<hal::PlanarPose> bodies_;
  std::vector<nav::TeamWord> words_;
  std::vector<std::unique_ptr<net::TeamTalk>> talks_;
  int shared_places_ = 0;
};

}  // namespace g3d::tests
