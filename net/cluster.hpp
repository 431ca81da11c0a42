// SPDX-License-Identifier: Apache-2.0
// Which robots form a cluster with us, and who leads it. A cluster is all whom a chain of robots joins, of which every
// two neighbours hear each other; what each one hears it says in its ContactWord. Nobody is asked and nothing is voted
// on in rounds: every robot follows whom most of its cluster follow, and says so.
//
//   a leader is in the cluster and says itself that it leads ─▶ the one with most followers counts, of equals the
//   lowest id
//   there has been none for a while ─▶ of those who take part the lowest id begins a new term of office
//
// So who joins changes nothing, unless it leads more; and when the leader dies, or the cluster is cut in two, those
// without one get a new one, with a term that none of them has seen before. All that hear each other and are left in
// peace come to follow the same one. One thread; allocates at construction.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "net/robot_status.hpp"

namespace g3d::net {

struct ClusterRule {
  hal::TimeNs listen_ns = 2'500'000'000;  ///< who has started hears first whether somebody leads
  hal::TimeNs vacant_ns = 1'000'000'000;  ///< so long nobody leads before somebody begins to
};

/// What a robot last said.
struct ContactOf {
  RobotId robot = 0;
  ContactWord word;
};

struct ClusterCounts {
  std::uint64_t begun_terms = 0;      ///< by ourselves
  std::uint64_t changed_leaders = 0;  ///< whom we follow, nobody included
};

class Cluster {
 public:
  /// `most_robots`: that there can be; from `now_ns` on it listens.
  Cluster(RobotId self, std::size_t most_robots, const ClusterRule& rule, hal::TimeNs now_ns);

  /// About ten times a second. `heard`: robots that we hear, ascending. `words`: the latest of others, one for each.
  void update(std::span<const RobotId> heard, std::span<const ContactOf> words, hal::TimeNs now_ns);

  /// With ourselves, ascending.
  [[nodiscard]] std::span<const RobotId> members() const { return members_; }
  [[nodiscard]] bool has(RobotId robot) const;
  /// Whom we follow; robot 0: nobody.
  [[nodiscard]] const Office& office() const { return own_.office; }
  [[nodiscard]] bool is_leader() const { return own_.office.leader == self_; }
  /// What is to be told.
  [[nodiscard]] const ContactWord& word() const { return own_; }
  [[nodiscard]] const ClusterCounts& counts() const { return counts_; }

 private:
  void find_members(std::span<const ContactOf> words);
  void follow(std::span<const ContactOf> words, hal::TimeNs now_ns);
  [[nodiscard]] Office most_followed(std::span<const ContactOf> words) const;
  void take(const Office& office);

  RobotId self_;
  ClusterRule rule_;
  hal::TimeNs begun_ns_;
  hal::TimeNs led_ns_;  ///< when somebody led last
  ContactWord own_;
  std::uint64_t highest_term_ = 0;
  std::vector<RobotId> members_;
  std::vector<RobotId> open_;  ///< members whose neighbours are still to be looked at
  ClusterCounts counts_;
};

}  // namespace g3d::net
