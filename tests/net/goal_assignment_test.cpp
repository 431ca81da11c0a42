// SPDX-License-Identifier: Apache-2.0
#include "net/goal_assignment.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "net/claim_book.hpp"

using namespace g3d;
using net::AssignmentRule;
using net::Bidder;
using net::GoalAssignment;

namespace {

nav::Offer place(double x_m, double y_m, float travel_s, float gain_cells = 100.0F) {
  return {{x_m, y_m, 0.0}, travel_s, gain_cells};
}

struct Bids {
  std::vector<std::vector<nav::Offer>> offers;
  [[nodiscard]] std::vector<Bidder> bidders() const {
    std::vector<Bidder> all;
    for (std::size_t i = 0; i < offers.size(); ++i) all.push_back({i + 1, offers[i], std::nullopt});
    return all;
  }
};

Bids bids_of_chance(hal::SeededRandom& random, std::size_t robots, std::size_t most_offers, double extent_m) {
  Bids bids;
  for (std::size_t i = 0; i < robots; ++i) {
    bids.offers.emplace_back();
    const double x_m = random.uniform() * extent_m, y_m = random.uniform() * extent_m;
    for (std::size_t k = random.bits() % (most_offers + 1); k > 0; --k) {
      nav::Offer offer = place(random.uniform() * extent_m, random.uniform() * extent_m, 0.0F,
                               static_cast<float>(random.bits() % 3000));
      offer.travel_s = static_cast<float>(std::hypot(offer.goal.x_m - x_m, offer.goal.y_m - y_m) / 0.3);
      bids.offers.back().push_back(offer);
    }
  }
  return bids;
}

double nearest_two_m(const std::vector<Bidder>& bidders, std::span<const int> chosen) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < bidders.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (chosen[a] < 0 || chosen[b] < 0) continue;
      nearest_m = std::min(nearest_m, net::apart_m(bidders[a].offers[static_cast<std::size_t>(chosen[a])].goal,
                                                   bidders[b].offers[static_cast<std::size_t>(chosen[b])].goal));
    }
  }
  return nearest_m;
}

/// As the header says it, written down plainly.
double plain_cost_s(const AssignmentRule& rule, const std::vector<Bidder>& bidders, const std::vector<int>& chosen) {
  double sum_s = 0.0;
  for (std::size_t i = 0; i < bidders.size(); ++i) {
    if (chosen[i] < 0) {
      sum_s += rule.idle_s;
      continue;
    }
    const nav::Offer& offer = bidders[i].offers[static_cast<std::size_t>(chosen[i])];
    sum_s += offer.travel_s + rule.rank_s * chosen[i] - rule.gain_s * std::log2(1.0 + offer.gain_cells);
    for (std::size_t other = 0; other < i; ++other) {
      if (chosen[other] < 0) continue;
      const double d_m = net::apart_m(offer.goal, bidders[other].offers[static_cast<std::size_t>(chosen[other])].goal);
      if (d_m < rule.apart_m) return std::numeric_limits<double>::infinity();
      sum_s += rule.crowded_s * std::max(0.0, 1.0 - d_m / rule.crowded_m);
    }
  }
  return sum_s;
}

double best_of_all_s(const AssignmentRule& rule, const std::vector<Bidder>& bidders, std::vector<int>& chosen,
                     std::size_t i) {
  if (i == bidders.size()) return plain_cost_s(rule, bidders, chosen);
  double best_s = std::numeric_limits<double>::infinity();
  for (chosen[i] = -1; chosen[i] < static_cast<int>(bidders[i].offers.size()); ++chosen[i]) {
    best_s = std::min(best_s, best_of_all_s(rule, bidders, chosen, i + 1));
  }
  return best_s;
}

}  // namespace

TEST_CASE("no two robots get one place, though both would go there first", "[net][assignment]") {
  const Bids bids{{{place(5, 0, 10), place(0, 5, 14)}, {place(5, 0, 4), place(0, 5, 30)}}};
  GoalAssignment assignment({});
  const auto chosen = assignment.assign(bids.bidders());
  REQUIRE(chosen.size() == 2);
  CHECK(chosen[0] == 1);
  CHECK(chosen[1] == 0);
}

TEST_CASE("who has nothing but what another one gets, gets nothing", "[net][assignment]") {
  const Bids bids{{{place(5, 0, 10)}, {place(5.5, 0, 4)}, {}}};
  GoalAssignment assignment({});
  const auto chosen = assignment.assign(bids.bidders());
  CHECK(chosen[0] == GoalAssignment::kNoOffer);
  CHECK(chosen[1] == 0);
  CHECK(chosen[2] == GoalAssignment::kNoOffer);
}

TEST_CASE("of places that are as far the one apart from the other robot's is taken", "[net][assignment]") {
  const Bids bids{{{place(10, 0, 20)}, {place(8, 0, 20), place(-8, 0, 20)}}};
  AssignmentRule rule;
  rule.rank_s = 0.0;  // neither is dearer to it
  GoalAssignment assignment(rule);
  CHECK(assignment.assign(bids.bidders())[1] == 1);
}

TEST_CASE("who is on its way is not turned round for little", "[net][assignment]") {
  const Bids bids{{{place(10, 0, 20), place(-10, 0, 19)}}};
  AssignmentRule rule;
  rule.rank_s = 0.0;
  GoalAssignment assignment(rule);
  std::vector<Bidder> bidders = bids.bidders();
  CHECK(assignment.assign(bidders)[0] == 1);
  bidders[0].keeps = hal::PlanarPose{10.1, 0.1, 3.0};
  CHECK(assignment.assign(bidders)[0] == 0);
}

TEST_CASE("for few robots the best distribution is found", "[net][assignment]") {
  hal::SeededRandom random(17);
  const AssignmentRule rule;
  GoalAssignment assignment(rule);
  for (int i = 0; i < 200; ++i) {
    const Bids bids = bids_of_chance(random, 1 + random.bits() % 4, 4, 12.0);
    const std::vector<Bidder> bidders = bids.bidders();
    const auto chosen = assignment.assign(bidders);
    const double cost_s = plain_cost_s(rule, bidders, {chosen.begin(), chosen.end()});
    std::vector<int> any(bidders.size(), -1);
    CHECK(cost_s == Approx(best_of_all_s(rule, bidders, any, 0)).margin(1e-6));
    CHECK(assignment.cost_s() == Approx(cost_s).margin(1e-6));
  }
}

TEST_CASE("for many robots no two are near each other either, and the same bids give the same", "[net][assignment]") {
  hal::SeededRandom random(18);
  const AssignmentRule rule;
  for (int i = 0; i < 30; ++i) {
    const Bids bids = bids_of_chance(random, 2 + random.bits() % (net::kMostOrders - 1), nav::kMostOffers, 15.0);
    const std::vector<Bidder> bidders = bids.bidders();
    GoalAssignment one(rule), other(rule);
    const auto chosen = one.assign(bidders);
    CHECK(nearest_two_m(bidders, chosen) >= rule.apart_m);
    const auto again = other.assign(bidders);
    CHECK(std::equal(chosen.begin(), chosen.end(), again.begin(), again.end()));
  }
}

TEST_CASE("numbers that are none do no harm", "[net][assignment]") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const Bids bids{{{place(5, 0, nan, 3.0F), place(0, 5, 14)}, {place(5, 0, infinite), place(9, 5, 3, nan)}}};
  GoalAssignment assignment({});
  const auto chosen = assignment.assign(bids.bidders());
  CHECK(chosen[0] == 1);
  CHECK(chosen[1] >= 0);
}
