// SPDX-License-Identifier: Apache-2.0
// Clusters without any map: robots that beacon twice a second, and with every beacon that comes through hand over all
// that they know of what the others said. Fast enough for very many schedules; the radio is cut by groups, and loses.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "net/cluster.hpp"

namespace g3d::tests {

class ClusterModel {
 public:
  static constexpr hal::TimeNs kStep_ns = 100'000'000;
  static constexpr hal::TimeNs kGone_ns = 3'250'000'000;

  ClusterModel(std::uint32_t robots, double loss, std::uint64_t seed);

  void run(hal::TimeNs duration_ns);
  void kill(std::uint32_t i) { robots_[i] = nullptr; }
  void start(std::uint32_t i);
  void set_group(std::uint32_t i, int group) { groups_[i] = group; }
  void set_loss(double loss) { loss_ = loss; }
  /// Robots `a` and `b` do not hear each other, though they may be in one group.
  void set_wall(std::uint32_t a, std::uint32_t b, bool stands);
  void clear_walls() { walls_.assign(walls_.size(), false); }

  [[nodiscard]] bool is_alive(std::uint32_t i) const { return robots_[i] != nullptr; }
  [[nodiscard]] net::RobotId id(std::uint32_t i) const { return 10 * (i + 1); }
  [[nodiscard]] const net::Cluster& cluster(std::uint32_t i) const { return robots_[i]->cluster; }
  [[nodiscard]] hal::TimeNs now_ns() const { return now_ns_; }
  /// Of those that live and are joined with robot `i`, by chains, ascending.
  [[nodiscard]] std::vector<net::RobotId> component(std::uint32_t i) const;
  /// All that are joined know it and follow one of them, who knows that it leads.
  [[nodiscard]] bool is_settled() const;
  [[nodiscard]] std::uint64_t changed_leaders() const;

 private:
  struct Known {
    std::uint64_t version = 0;  ///< 0: nothing
    net::ContactWord word;
  };
  struct Robot {
    Robot(net::RobotId self, std::uint32_t robots, hal::TimeNs now_ns)
        : cluster(self, robots, {}, now_ns), heard_ns(robots, -kGone_ns), known(robots) {}
    net::Cluster cluster;
    std::vector<hal::TimeNs> heard_ns;
    std::vector<Known> known;
  };
  [[nodiscard]] bool hears(std::uint32_t a, std::uint32_t b) const {
    return a != b && robots_[a] != nullptr && robots_[b] != nullptr && groups_[a] == groups_[b] &&
           !walls_[a * groups_.size() + b];
  }
  void step();
  void look(std::uint32_t i);

  double loss_;
  hal::SeededRandom random_;
  std::vector<int> groups_;
  std::vector<bool> walls_;
  std::vector<std::uint64_t> versions_;  ///< outlive their robot, as incarnations do
  std::vector<std::unique_ptr<Robot>> robots_;
  std::vector<net::RobotId> heard_;
  std::vector<net::ContactOf> words_;
  hal::TimeNs now_ns_ = 0;
};

}  // namespace g3d::tests
