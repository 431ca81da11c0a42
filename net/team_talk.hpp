// SPDX-License-Identifier: Apache-2.0
// A robot's part in its team: it tells the others of itself, knows who belongs to its cluster, follows a leader or
// leads, and says to its own navigator what that needs to know of the others.
//
//   nav::TeamWord ──▶ StatusWriter ──▶ own layer ──gossip──▶ others' layers ──▶ StatusBook ──▶ Cluster, ClaimBook
//   nav::TeamSight ◀── members' places and ways, claims that stand, what the leader ordered ◀─────────┘
//                                          a leader: GoalAssignment ──▶ orders
//
// Robots that are not heard of any more claim nothing: their bodies alone are in sight, where they were last. Who has
// no leader, or none that has a place for it, acts on its own. Orders that are not of the leader that it follows now
// are void. One thread; allocates at construction.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "hal/messages.hpp"
#include "nav/teammates.hpp"
#include "net/claim_book.hpp"
#include "net/cluster.hpp"
#include "net/goal_assignment.hpp"
#include "net/gossip.hpp"
#include "net/status_book.hpp"
#include "net/status_writer.hpp"

namespace g3d::net {

struct TeamTalkOptions {
  ClusterRule cluster;
  StatusPace pace;
  AssignmentRule assignment;
  double same_claim_m = 1.0;  ///< goals nearer to each other are one place
  hal::TimeNs look_every_ns = 100'000'000;
  hal::TimeNs assign_every_ns = 1'000'000'000;
};

struct TeamTalkCounts {
  std::uint64_t assignments = 0;     ///< that we made as a leader
  std::uint64_t orders = 0;          ///< in these: places that were not the robot's own first choice
  std::uint64_t beaten_claims = 0;   ///< looks at which our own claim did not stand
  std::uint64_t left_out_mates = 0;  ///< more than fit into one sight
};

class TeamTalk {
 public:
  /// `gossip` and its `store` outlive this.
  TeamTalk(const TeamTalkOptions& options, Gossip& gossip, const LayerStore& store, hal::TimeNs now_ns);

  /// Every 5 to 20 ms, before Gossip::on_time(). Returns whether sight() may have changed.
  bool on_time(const nav::TeamWord& own, const StateWord& state, hal::TimeNs now_ns);

  [[nodiscard]] const nav::TeamSight& sight() const { return sight_; }
  [[nodiscard]] const Cluster& cluster() const { return cluster_; }
  [[nodiscard]] const StatusBook& book() const { return book_; }
  [[nodiscard]] const ClaimBook& claims() const { return claims_; }
  /// What we order as a leader, or ordered last.
  [[nodiscard]] const OrdersWord& own_orders() const { return orders_; }
  [[nodiscard]] const StatusCounts& said() const { return writer_.counts(); }
  [[nodiscard]] const TeamTalkCounts& counts() const { return counts_; }

 private:
  void look(hal::TimeNs now_ns);
  void lead(const nav::TeamWord& own);
  /// Of the leader that we follow; nullptr: there are none that count.
  [[nodiscard]] const OrdersWord* standing_orders() const;
  [[nodiscard]] std::optional<hal::PlanarPose> order_for(RobotId robot) const;
  [[nodiscard]] std::optional<hal::PlanarPose> assigned_to(const nav::TeamWord& own) const;
  void settle_claims(const nav::TeamWord& own);
  void show(const nav::TeamWord& own, hal::TimeNs now_ns);

  TeamTalkOptions options_;
  RobotId self_;
  const Gossip& gossip_;
  const LayerStore& store_;
  StatusWriter writer_;
  StatusBook book_;
  Cluster cluster_;
  ClaimBook claims_;
  GoalAssignment assignment_;
  OrdersWord orders_;
  nav::TeamSight sight_;
  std::vector<RobotId> heard_;  ///< reserved, as the next
  std::vector<ContactOf> contacts_;
  std::vector<const RobotWords*> mates_;
  hal::TimeNs looked_ns_;
  hal::TimeNs assigned_ns_;
  TeamTalkCounts counts_;
};

}  // namespace g3d::net
