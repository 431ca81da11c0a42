// SPDX-License-Identifier: Apache-2.0
// Gossip in crowds: what goes to all, and who answers it how.
#include <algorithm>
#include <catch2/catch.hpp>

#include "net/gossip.hpp"
#include "tests/support/gossip_fleet.hpp"

using namespace g3d;
using tests::FleetOptions;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kWordsSecond = 1'000'000'000;

std::uint64_t sent_of(GossipFleet& fleet, std::uint32_t robots, net::MessageKind kind) {
  std::uint64_t sum = 0;
  for (std::uint32_t i = 0; i < robots; ++i) {
    sum += fleet.gossip(i).counts().sent_messages[static_cast<std::size_t>(kind)];
  }
  return sum;
}

}  // namespace

TEST_CASE("a crowd is told once and answers together", "[net][gossip]") {
  constexpr std::uint32_t kRobots = 12;
  FleetOptions options;
  options.robots = kRobots;
  GossipFleet fleet(options);
  fleet.run(3 * kWordsSecond);
  const std::uint64_t bytes_before = fleet.sent_bytes();
  std::size_t content = 0;
  for (int round = 0; round < 4; ++round) {
    for (std::uint32_t i = 0; i < kRobots; ++i) content += fleet.publish_scan(i, 30);
    fleet.run(kWordsSecond / 2);
  }
  REQUIRE(fleet.run_until_equal(2 * kWordsSecond));
  CHECK(sent_of(fleet, kRobots, net::MessageKind::data) == 0);
  const std::uint64_t news = sent_of(fleet, kRobots, net::MessageKind::news);
  CHECK(news >= 4 * kRobots);
  // Eleven would answer each of them.
  CHECK(sent_of(fleet, kRobots, net::MessageKind::wants) < 2 * news);
  // Less than the content twice, where a copy for each would be eleven times it.
  CHECK(fleet.sent_bytes() - bytes_before < 2 * content);
}

TEST_CASE("robots in a row, each hearing its neighbours alone, come to hold the same over a bad radio",
          "[net][gossip]") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    INFO("seed " << seed);
    FleetOptions options;
    options.robots = 7;
    options.radio.loss = 0.05 * static_cast<double>(seed);
    options.radio.late = 0.05;
    options.radio.doubled = 0.05;
    options.radio.seed = seed;
    options.reach = 1 + seed % 2;
    GossipFleet fleet(options);
    fleet.run(2 * kWordsSecond);
    for (int round = 0; round < 6; ++round) {
      for (std::uint32_t i = 0; i < options.robots; ++i) fleet.publish(i, 8, 60);
      fleet.run(kWordsSecond / 3);
    }
    CHECK(fleet.run_until_equal(40 * kWordsSecond));
    CHECK(fleet.standing(0) == fleet.standing(6));
  }
}

TEST_CASE("a robot that another one asks for a third one's layer tells all who want it at once", "[net][gossip]") {
  FleetOptions options;
  options.robots = 4;
  GossipFleet fleet(options);
  fleet.set_group(2, 1);
  fleet.set_group(3, 1);
  fleet.run(2 * kWordsSecond);
  fleet.publish(0, 300, 3000);
  REQUIRE_FALSE(fleet.run_until_equal(3 * kWordsSecond));
  fleet.kill(0);
  fleet.join_all();
  REQUIRE(fleet.run_until_equal(10 * kWordsSecond));
  CHECK(fleet.gossip(1).counts().sent_messages[static_cast<std::size_t>(net::MessageKind::news)] > 10);
}
