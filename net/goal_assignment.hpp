// SPDX-License-Identifier: Apache-2.0
// Who goes where, as the leader of a cluster has it: each robot has told where it could go to next, how long it would
// drive and how much it would see, and gets one of these places or none. No two get places that are near each other, as
// one would see what the other came for and both would come through one door; places are the better, the further apart.
// Who was sent to one is not sent elsewhere for little. The best of all distributions by exhaustive search while there
// are few robots, else the best that was found in so many steps. A function of its arguments. One thread; allocates
// nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "hal/twist.hpp"
#include "nav/teammates.hpp"
#include "net/layer_id.hpp"
#include "net/robot_status.hpp"

namespace g3d::net {

struct Bidder {
  RobotId robot = 0;
  std::span<const nav::Offer> offers;    ///< at most nav::kMostOffers; the one it would take by itself first
  std::optional<hal::PlanarPose> keeps;  ///< where it was sent to before
};

struct AssignmentRule {
  double same_m = 0.75;    ///< nearer to each other: the same place
  double apart_m = 1.5;    ///< no two robots nearer than this
  double crowded_m = 4.0;  ///< two that are nearer disturb each other,
  double crowded_s = 3.0;  ///< and lose so much time if they are at one place
  double rank_s = 12.0;    ///< that a robot loses by taking its second choice, twice that its third
  double gain_s = 4.0;     ///< that a place is worth which shows twice as much
  double kept_s = 5.0;     ///< that it takes to turn round
  double idle_s = 200.0;   ///< that a robot without a place loses
  std::uint32_t most_steps = 4'000;
};

class GoalAssignment {
 public:
  static constexpr int kNoOffer = -1;
  explicit GoalAssignment(const AssignmentRule& rule) : rule_(rule) {}

  /// `bidders`: at most kMostOrders, ascending by id. Returns for each the index of its offer, or kNoOffer, until the
  /// next call.
  std::span<const int> assign(std::span<const Bidder> bidders);
  /// Of the last distribution, in seconds.
  [[nodiscard]] double cost_s() const { return best_s_; }
  [[nodiscard]] const AssignmentRule& rule() const { return rule_; }

 private:
  using Choice = std::array<int, kMostOrders>;
  [[nodiscard]] double alone_s(const Bidder& bidder, int offer) const;
  /// Infinite: not both.
  [[nodiscard]] double together_s(const hal::PlanarPose& a, const hal::PlanarPose& b) const;
  /// What bidder `i` adds by `offer`, beside those bidders that `choice` has a place for and `counts` says.
  template <typename Counts>
  [[nodiscard]] double added_s(const Choice& choice, std::size_t i, int offer, Counts&& counts) const;
  void choose_greedily();
  void improve();
  void search(std::size_t i, double sum_s);

  AssignmentRule rule_;
  std::span<const Bidder> bidders_;
  std::array<std::array<double, nav::kMostOffers + 1>, kMostOrders> alone_s_{};  ///< by bidder and offer + 1
  std::array<std::array<int, nav::kMostOffers + 1>, kMostOrders> order_{};       ///< offers, the cheapest first
  std::array<double, kMostOrders + 1> at_least_s_{};                             ///< of bidders from here on
  Choice choice_{};
  Choice best_{};
  double best_s_ = 0.0;
  std::uint32_t steps_left_ = 0;
};

}  // namespace g3d::net
