// SPDX-License-Identifier: Apache-2.0
#include "net/cluster.hpp"

#include <algorithm>

namespace g3d::net {
namespace {

const ContactWord* contact_of(std::span<const ContactOf> words, RobotId robot) {
  const auto it = std::find_if(words.begin(), words.end(), [&](const ContactOf& of) { return of.robot == robot; });
  return it == words.end() ? nullptr : &it->word;
}

void insert_ascending(std::vector<RobotId>& robots, RobotId robot) {
  robots.insert(std::lower_bound(robots.begin(), robots.end(), robot), robot);
}

}  // namespace

Cluster::Cluster(RobotId self, std::size_t most_robots, const ClusterRule& rule, hal::TimeNs now_ns)
    : self_(self), rule_(rule), begun_ns_(now_ns), led_ns_(now_ns) {
  members_.reserve(most_robots + 1);
  open_.reserve(most_robots + 1);
  members_.push_back(self);
}

bool Cluster::has(RobotId robot) const { return std::binary_search(members_.begin(), members_.end(), robot); }

void Cluster::update(std::span<const RobotId> heard, std::span<const ContactOf> words, hal::TimeNs now_ns) {
  own_.heard_count = std::min(heard.size(), own_.heard.size());
  std::copy_n(heard.begin(), own_.heard_count, own_.heard.begin());
  for (const ContactOf& of : words) highest_term_ = std::max(highest_term_, of.word.office.term);
  find_members(words);
  follow(words, now_ns);
}

void Cluster::find_members(std::span<const ContactOf> words) {
  members_.assign(1, self_);
  open_.assign(1, self_);
  while (!open_.empty()) {
    const RobotId robot = open_.back();
    open_.pop_back();
    const ContactWord* const word = robot == self_ ? &own_ : contact_of(words, robot);
    for (const RobotId neighbour : word->all_heard()) {
      const ContactWord* const theirs = contact_of(words, neighbour);
      if (theirs == nullptr || !theirs->hears(robot) || has(neighbour)) continue;
      if (members_.size() == members_.capacity()) return;
      insert_ascending(members_, neighbour);
      open_.push_back(neighbour);
    }
  }
}

Office Cluster::most_followed(std::span<const ContactOf> words) const {
  const auto office_of = [&](RobotId robot) { return robot == self_ ? own_.office : contact_of(words, robot)->office; };
  Office best;
  std::ptrdiff_t most = 0;
  // Ascending, so that of equals the lowest id stays.
  for (const RobotId robot : members_) {
    const Office office = office_of(robot);
    if (office.leader != robot) continue;
    const auto followers = std::count_if(members_.begin(), members_.end(),
                                         [&](RobotId other) { return office_of(other).leader == robot; });
    if (followers > most) {
      most = followers;
      best = office;
    }
  }
  return best;
}

void Cluster::follow(std::span<const ContactOf> words, hal::TimeNs now_ns) {
  const Office best = most_followed(words);
  if (best.leader != 0) {
    led_ns_ = now_ns;
    return take(best);
  }
  if (now_ns - led_ns_ < rule_.vacant_ns || now_ns - begun_ns_ < rule_.listen_ns) return take({});
  // Others with lower ids may be about to begin: they see what we see.
  if (members_.front() != self_) return take({});
  ++counts_.begun_terms;
  led_ns_ = now_ns;
  take({self_, ++highest_term_});
}

void Cluster::take(const Office& office) {
  highest_term_ = std::max(highest_term_, office.term);
  if (office.leader != own_.office.leader) ++counts_.changed_leaders;
  own_.office = office;
}

}  // namespace g3d::net
