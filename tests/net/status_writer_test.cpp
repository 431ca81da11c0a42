// SPDX-License-Identifier: Apache-2.0
#include "net/status_writer.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using net::StatusKind;
using net::StatusWriter;

namespace {

struct DeafLink final : net::Link {
  bool send(net::Address, mapper::ByteSpan) override { return true; }
};

struct WriterBench {
  net::LayerStore store{{4, 64, 1 << 16, 16}};
  DeafLink link;
  net::Gossip gossip{[] {
                       net::GossipOptions options;
                       options.self = {1, 1};
                       return options;
                     }(),
                     store, link};
  StatusWriter writer{{}, gossip};

  [[nodiscard]] std::uint64_t said(StatusKind kind) const {
    return writer.counts().words[static_cast<std::size_t>(kind)];
  }
  /// For ten seconds, every 100 ms: `word` at that many seconds.
  template <typename Word>
  void say_for_ten_s(Word&& word) {
    for (int i = 0; i < 100; ++i) {
      writer.say(word(0.1 * i), 2, now_ns);
      now_ns += 100'000'000;
    }
  }
  hal::TimeNs now_ns = 1'000'000'000;
};

net::MotionWord moving_at(double x_m) {
  net::MotionWord word;
  word.T_world_base.x_m = x_m;
  word.is_moving = true;
  return word;
}

}  // namespace

TEST_CASE("a robot that moves says so a few times a second, one that stands not at all", "[net][status]") {
  WriterBench bench;
  bench.say_for_ten_s([](double s) { return moving_at(0.3 * s); });
  CHECK(bench.said(StatusKind::motion) == 25);
  net::MotionWord still = moving_at(3.0);
  still.is_moving = false;
  bench.say_for_ten_s([&](double) { return still; });
  CHECK(bench.said(StatusKind::motion) == 26);
  // Noise of odometry is no motion; to be pushed away is.
  bench.say_for_ten_s([&](double s) {
    net::MotionWord word = still;
    word.T_world_base.x_m += 0.02 * (s > 5.0 ? 1 : -1);
    word.T_world_base.heading_rad = 0.04;
    return word;
  });
  CHECK(bench.said(StatusKind::motion) == 26);
  still.T_world_base.x_m += 0.2;
  bench.say_for_ten_s([&](double) { return still; });
  CHECK(bench.said(StatusKind::motion) == 27);
}

TEST_CASE("a new goal is told at once, and the first of many within a tenth of a second", "[net][status]") {
  WriterBench bench;
  net::MotionWord word = moving_at(0.0);
  bench.writer.say(word, 2, bench.now_ns);
  word.has_goal = true;
  word.goal = {3.0, 1.0, 0.0};
  bench.writer.say(word, 2, bench.now_ns + 50'000'000);
  CHECK(bench.said(StatusKind::motion) == 1);
  bench.writer.say(word, 2, bench.now_ns + 100'000'000);
  CHECK(bench.said(StatusKind::motion) == 2);
  net::MotionWord stored;
  const auto record = bench.store.find_record(bench.gossip.own_layer(), net::status_key(StatusKind::motion));
  REQUIRE(record);
  mapper::Bytes payload(record->bytes);
  bench.store.read(*record, payload);
  REQUIRE(net::read_status(payload, stored) == net::StatusFault::none);
  CHECK(stored.has_goal);
  CHECK(stored.said_ms == 1100);
}

TEST_CASE("the more are told, the less often", "[net][status]") {
  WriterBench bench;
  for (int i = 0; i < 100; ++i) {
    bench.writer.say(moving_at(0.1 * i), 50, bench.now_ns);
    bench.now_ns += 100'000'000;
  }
  CHECK(bench.said(StatusKind::motion) == 5);
}

TEST_CASE("offers are told when others would choose otherwise by them", "[net][status]") {
  WriterBench bench;
  net::OffersWord word;
  bench.writer.say(word, bench.now_ns);
  CHECK(bench.said(StatusKind::offers) == 0);
  word.count = 1;
  word.offers[0] = {{1.0, 2.0, 0.0}, 20.0F, 100.0F};
  bench.writer.say(word, bench.now_ns);
  CHECK(bench.said(StatusKind::offers) == 1);
  word.offers[0].travel_s = 19.0F;
  word.offers[0].gain_cells = 95.0F;
  bench.writer.say(word, bench.now_ns + 5'000'000'000);
  CHECK(bench.said(StatusKind::offers) == 1);
  word.offers[0].travel_s = 12.0F;
  bench.writer.say(word, bench.now_ns + 500'000'000);
  CHECK(bench.said(StatusKind::offers) == 1);
  bench.writer.say(word, bench.now_ns + 6'000'000'000);
  CHECK(bench.said(StatusKind::offers) == 2);
  word.count = 0;
  bench.writer.say(word, bench.now_ns + 7'000'000'000);
  CHECK(bench.said(StatusKind::offers) == 3);
}

TEST_CASE("state, contact and orders are told when they change", "[net][status]") {
  WriterBench bench;
  net::StateWord state{nav::MissionState::exploring, 80, 0.18F, 1};
  net::ContactWord contact;
  net::OrdersWord orders;
  for (int i = 0; i < 50; ++i) {
    bench.now_ns += 100'000'000;
    bench.writer.say(state, bench.now_ns);
    bench.writer.say(contact, bench.now_ns);
    bench.writer.say(orders, bench.now_ns);
  }
  CHECK(bench.said(StatusKind::state) == 1);
  CHECK(bench.said(StatusKind::contact) == 1);
  CHECK(bench.said(StatusKind::orders) == 0);
  state.battery_percent = 79;
  contact.office = {1, 1};
  orders.term = 1;
  orders.count = 1;
  orders.orders[0] = {4, {}};
  bench.now_ns += 1'000'000'000;
  bench.writer.say(state, bench.now_ns);
  bench.writer.say(contact, bench.now_ns);
  bench.writer.say(orders, bench.now_ns);
  CHECK(bench.said(StatusKind::state) == 2);
  CHECK(bench.said(StatusKind::contact) == 2);
  CHECK(bench.said(StatusKind::orders) == 1);
}

TEST_CASE("what the store has no room for is said later", "[net][status]") {
  WriterBench bench;
  net::LayerStore full({4, 1, 1 << 12, 16});
  net::Gossip gossip(bench.gossip.options(), full, bench.link);
  REQUIRE(gossip.publish(net::status_record(77), net::Lane::ground, {}));
  StatusWriter writer({}, gossip);
  writer.say(net::StateWord{}, bench.now_ns);
  CHECK(writer.counts().refused == 1);
  CHECK(writer.counts().words[static_cast<std::size_t>(StatusKind::state)] == 0);
  writer.say(net::StateWord{}, bench.now_ns);
  CHECK(writer.counts().refused == 2);
}
