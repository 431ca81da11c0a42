// SPDX-License-Identifier: Apache-2.0
#include "tests/support/cluster_model.hpp"

#include <algorithm>

namespace g3d::tests {

ClusterModel::ClusterModel(std::uint32_t robots, double loss, std::uint64_t seed)
    : loss_(loss),
      random_(seed),
      groups_(robots, 0),
      walls_(std::size_t{robots} * robots, false),
      versions_(robots, 0),
      robots_(robots) {
  for (std::uint32_t i = 0; i < robots; ++i) start(i);
}

void ClusterModel::start(std::uint32_t i) {
  robots_[i] = std::make_unique<Robot>(id(i), static_cast<std::uint32_t>(groups_.size()), now_ns_);
}

void ClusterModel::set_wall(std::uint32_t a, std::uint32_t b, bool stands) {
  walls_[a * groups_.size() + b] = walls_[b * groups_.size() + a] = stands;
}

void ClusterModel::look(std::uint32_t i) {
  Robot& robot = *robots_[i];
  heard_.clear();
  words_.clear();
  for (std::uint32_t k = 0; k < robots_.size(); ++k) {
    if (k == i) continue;
    if (now_ns_ - robot.heard_ns[k] < kGone_ns) heard_.push_back(id(k));
    if (robot.known[k].version > 0) words_.push_back({id(k), robot.known[k].word});
  }
  robot.cluster.update(heard_, words_, now_ns_);
  robot.known[i] = {++versions_[i], robot.cluster.word()};
}

void ClusterModel::step() {
  now_ns_ += kStep_ns;
  for (std::uint32_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i] != nullptr) look(i);
  }
  // Each at its own time.
  for (std::uint32_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i] == nullptr || (now_ns_ / kStep_ns + i) % 5 != 0) continue;
    for (std::uint32_t to = 0; to < robots_.size(); ++to) {
      if (!hears(i, to) || random_.happens(loss_)) continue;
      robots_[to]->heard_ns[i] = now_ns_;
      for (std::uint32_t of = 0; of < robots_.size(); ++of) {
        const Known& news = robots_[i]->known[of];
        if (of != to && news.version > robots_[to]->known[of].version) robots_[to]->known[of] = news;
      }
    }
  }
}

void ClusterModel::run(hal::TimeNs duration_ns) {
  for (const hal::TimeNs end = now_ns_ + duration_ns; now_ns_ < end;) step();
}

std::vector<net::RobotId> ClusterModel::component(std::uint32_t i) const {
  std::vector<bool> is_in(robots_.size(), false);
  std::vector<std::uint32_t> open{i};
  is_in[i] = true;
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    for (std::uint32_t k = 0; k < robots_.size(); ++k) {
      if (is_in[k] || !hears(at, k)) continue;
      is_in[k] = true;
      open.push_back(k);
    }
  }
  std::vector<net::RobotId> ids;
  for (std::uint32_t k = 0; k < robots_.size(); ++k) {
    if (is_in[k]) ids.push_back(id(k));
  }
  return ids;
}

bool ClusterModel::is_settled() const {
  for (std::uint32_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i] == nullptr) continue;
    const std::vector<net::RobotId> ids = component(i);
    const net::Cluster& cluster = robots_[i]->cluster;
    const auto members = cluster.members();
    if (!std::equal(ids.begin(), ids.end(), members.begin(), members.end())) return false;
    const net::RobotId leader = cluster.office().leader;
    if (!std::binary_search(ids.begin(), ids.end(), leader)) return false;
    const Robot& led_by = *robots_[leader / 10 - 1];
    if (!led_by.cluster.is_leader() || !(led_by.cluster.office() == cluster.office())) return false;
  }
  return true;
}

std::uint64_t ClusterModel::changed_leaders() const {
  std::uint64_t sum = 0;
  for (const auto& robot : robots_) sum += robot == nullptr ? 0 : robot->cluster.counts().changed_leaders;
  return sum;
}

}  // namespace g3d::tests
