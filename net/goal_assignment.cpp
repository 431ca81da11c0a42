// SPDX-License-Identifier: Apache-2.0
#include "net/goal_assignment.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "net/claim_book.hpp"

namespace g3d::net {
namespace {

constexpr double kNever_s = std::numeric_limits<double>::infinity();
/// Less is rounding.
constexpr double kAssignment_s = 1e-9;

std::size_t at(int offer) { return static_cast<std::size_t>(offer + 1); }
std::size_t offer_count(const Bidder& bidder) { return std::min(bidder.offers.size(), nav::kMostOffers); }

}  // namespace

double GoalAssignment::alone_s(const Bidder& bidder, int offer) const {
  if (offer == kNoOffer) return rule_.idle_s;
  const nav::Offer& of = bidder.offers[static_cast<std::size_t>(offer)];
  double cost_s = of.travel_s + rule_.rank_s * offer - rule_.gain_s * std::log2(1.0 + std::max(0.0F, of.gain_cells));
  if (bidder.keeps && apart_m(*bidder.keeps, of.goal) < rule_.same_m) cost_s -= rule_.kept_s;
  // Hostile numbers must not make a place better than it can be.
  return std::isfinite(cost_s) ? cost_s : rule_.idle_s;
}

double GoalAssignment::together_s(const hal::PlanarPose& a, const hal::PlanarPose& b) const {
  const double distance_m = apart_m(a, b);
  if (distance_m < rule_.apart_m) return kNever_s;
  return rule_.crowded_s * std::max(0.0, 1.0 - distance_m / rule_.crowded_m);
}

template <typename Counts>
double GoalAssignment::added_s(const Choice& choice, std::size_t i, int offer, Counts&& counts) const {
  double cost_s = alone_s_[i][at(offer)];
  if (offer == kNoOffer) return cost_s;
  const hal::PlanarPose& goal = bidders_[i].offers[static_cast<std::size_t>(offer)].goal;
  for (std::size_t other = 0; other < bidders_.size(); ++other) {
    if (other == i || !counts(other) || choice[other] == kNoOffer) continue;
    cost_s += together_s(goal, bidders_[other].offers[static_cast<std::size_t>(choice[other])].goal);
  }
  return cost_s;
}

std::span<const int> GoalAssignment::assign(std::span<const Bidder> bidders) {
  assert(bidders.size() <= kMostOrders);
  bidders_ = bidders.first(std::min(bidders.size(), kMostOrders));
  for (std::size_t i = 0; i < bidders_.size(); ++i) {
    const int count = static_cast<int>(offer_count(bidders_[i]));
    for (int offer = kNoOffer; offer < count; ++offer) {
      alone_s_[i][at(offer)] = alone_s(bidders_[i], offer);
      order_[i][at(offer)] = offer;
    }
    std::sort(order_[i].begin(), order_[i].begin() + count + 1, [&](int a, int b) {
      const double a_s = alone_s_[i][at(a)], b_s = alone_s_[i][at(b)];
      return a_s != b_s ? a_s < b_s : a < b;
    });
  }
  at_least_s_[bidders_.size()] = 0.0;
  for (std::size_t i = bidders_.size(); i-- > 0;) at_least_s_[i] = at_least_s_[i + 1] + alone_s_[i][at(order_[i][0])];
  choose_greedily();
  improve();
  best_ = choice_;
  best_s_ = 0.0;
  for (std::size_t i = 0; i < bidders_.size(); ++i) {
    best_s_ += added_s(choice_, i, choice_[i], [&](std::size_t other) { return other < i; });
  }
  steps_left_ = rule_.most_steps;
  search(0, 0.0);
  return {best_.data(), bidders_.size()};
}

/// Always the bidder next who gets its place cheapest.
void GoalAssignment::choose_greedily() {
  std::array<bool, kMostOrders> has_chosen{};
  choice_.fill(kNoOffer);
  for (std::size_t round = 0; round < bidders_.size(); ++round) {
    std::size_t best = bidders_.size();
    int best_offer = kNoOffer;
    double best_s = kNever_s;
    for (std::size_t i = 0; i < bidders_.size(); ++i) {
      if (has_chosen[i]) continue;
      for (std::size_t k = 0; k <= offer_count(bidders_[i]); ++k) {
        const double cost_s = added_s(choice_, i, order_[i][k], [&](std::size_t other) { return has_chosen[other]; });
        if (!(cost_s < best_s)) continue;
        best = i;
        best_offer = order_[i][k];
        best_s = cost_s;
      }
    }
    if (best == bidders_.size()) return;
    has_chosen[best] = true;
    choice_[best] = best_offer;
  }
}

/// One bidder after the other takes what is best beside all others, while that helps.
void GoalAssignment::improve() {
  const auto all = [](std::size_t) { return true; };
  for (std::size_t round = 0, still = 0; round < 20 * bidders_.size() && still < bidders_.size(); ++round) {
    const std::size_t i = round % bidders_.size();
    double best_s = added_s(choice_, i, choice_[i], all);
    ++still;
    for (std::size_t k = 0; k <= offer_count(bidders_[i]); ++k) {
      const double cost_s = added_s(choice_, i, order_[i][k], all);
      if (!(cost_s < best_s - kAssignment_s)) continue;
      best_s = cost_s;
      choice_[i] = order_[i][k];
      still = 0;
    }
  }
}

void GoalAssignment::search(std::size_t i, double sum_s) {
  if (sum_s + at_least_s_[i] >= best_s_ - kAssignment_s) return;
  if (i == bidders_.size()) {
    best_ = choice_;
    best_s_ = sum_s;
    return;
  }
  for (std::size_t k = 0; k <= offer_count(bidders_[i]) && steps_left_ > 0; ++k) {
    --steps_left_;
    choice_[i] = order_[i][k];
    search(i + 1, sum_s + added_s(choice_, i, choice_[i], [&](std::size_t other) { return other < i; }));
  }
}

}  // namespace g3d::net
