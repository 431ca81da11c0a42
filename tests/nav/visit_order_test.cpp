// SPDX-License-Identifier: Apache-2.0
#include "nav/visit_order.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

using namespace g3d::nav;

namespace {

struct Stop {
  double x, y, worth;
};

/// Stop 0 is where it begins.
void set_all(VisitOrder& order, const std::vector<Stop>& stops, bool keeps_first = false) {
  order.begin(stops.size() - 1, keeps_first);
  for (std::size_t i = 0; i < stops.size(); ++i) {
    order.set_worth(i, stops[i].worth);
    for (std::size_t j = 1; j < stops.size(); ++j) {
      order.set_seconds(i, j, std::hypot(stops[i].x - stops[j].x, stops[i].y - stops[j].y));
    }
  }
}

std::vector<std::uint16_t> solve(VisitOrder& order) {
  WorkBudget budget = WorkBudget::unlimited();
  REQUIRE(order.go_on(budget));
  return {order.order().begin(), order.order().end()};
}

double length(const std::vector<Stop>& stops, const std::vector<std::uint16_t>& order) {
  double sum = 0.0;
  std::size_t at = 0;
  for (const std::uint16_t next : order) {
    sum += std::hypot(stops[at].x - stops[next].x, stops[at].y - stops[next].y);
    at = next;
  }
  return sum;
}

std::vector<Stop> scattered(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Stop> stops;
  for (std::size_t i = 0; i < count; ++i) {
    stops.push_back({static_cast<double>(random() % 1000) / 50.0, static_cast<double>(random() % 1000) / 50.0, 1.0});
  }
  return stops;
}

}  // namespace

TEST_CASE("Stops along a line are visited one after the other") {
  VisitOrder order;
  order.reset(24, {});
  set_all(order, {{0, 0, 0}, {3, 0, 1}, {1, 0, 1}, {4, 0, 1}, {2, 0, 1}});
  CHECK(solve(order) == std::vector<std::uint16_t>{2, 4, 1, 3});
}

TEST_CASE("What is worth much comes early, even if it is a little farther") {
  VisitOrder order;
  order.reset(24, {});
  set_all(order, {{0, 0, 0}, {-3, 0, 1}, {4, 0, 50}});
  CHECK(solve(order) == std::vector<std::uint16_t>{2, 1});
}

TEST_CASE("A visit that has been begun stays first unless another is better by much") {
  VisitOrder order;
  order.reset(24, {});
  set_all(order, {{0, 0, 0}, {-4, 0, 10}, {3, 0, 10}}, true);
  CHECK(solve(order).front() == 1);
  CHECK(order.keeps_first());
  set_all(order, {{0, 0, 0}, {-4, 0, 10}, {3, 0, 10}}, false);
  CHECK(solve(order).front() == 2);
  set_all(order, {{0, 0, 0}, {-40, 0, 10}, {3, 0, 10}}, true);
  CHECK(solve(order).front() == 2);
  CHECK_FALSE(order.keeps_first());
}

TEST_CASE("All visits are in the order once, it beats the nearest neighbour, and pieces make the same order") {
  VisitOrder whole;
  VisitOrder pieces;
  whole.reset(24, {1.0, 0.0, 20});
  pieces.reset(24, {1.0, 0.0, 20});
  double ours = 0.0;
  double greedy = 0.0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const auto stops = scattered(20, seed);
    set_all(whole, stops);
    const auto order = solve(whole);
    auto sorted = order;
    std::sort(sorted.begin(), sorted.end());
    REQUIRE(sorted.size() == 19);
    for (std::size_t i = 0; i < sorted.size(); ++i) CHECK(sorted[i] == i + 1);

    set_all(pieces, stops);
    int calls = 1;
    for (;; ++calls) {
      WorkBudget budget(1);
      if (pieces.go_on(budget)) break;
      REQUIRE(calls < 100'000);
    }
    CHECK(calls > 19);
    CHECK(std::equal(order.begin(), order.end(), pieces.order().begin(), pieces.order().end()));

    std::vector<std::uint16_t> nearest;
    std::vector<bool> used(stops.size(), false);
    for (std::size_t at = 0; nearest.size() + 1 < stops.size(); at = nearest.back()) {
      std::size_t best = 0;
      for (std::size_t j = 1; j < stops.size(); ++j) {
        if (!used[j] && (best == 0 || whole.seconds(at, j) < whole.seconds(at, best))) best = j;
      }
      used[best] = true;
      nearest.push_back(static_cast<std::uint16_t>(best));
    }
    ours += length(stops, order);
    greedy += length(stops, nearest);
  }
  CHECK(ours < greedy);
}
