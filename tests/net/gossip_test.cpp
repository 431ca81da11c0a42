// SPDX-License-Identifier: Apache-2.0
#include "net/gossip.hpp"

#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "tests/support/gossip_fleet.hpp"

using namespace g3d;
using tests::FleetOptions;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

/// One schedule of chance: publishing, losing, doubling, overtaking, killing, starting anew, and cutting links; then
/// everybody hears everybody. All must come to hold the same, and nothing that anybody held then may be missing.
/// With disks, who starts anew finds there what it knew, but for what was not synced; now and then nothing at all.
void check_schedule(std::uint64_t seed, bool has_disks = false) {
  INFO("schedule " << seed << (has_disks ? " with disks" : ""));
  hal::SeededRandom random(seed);
  FleetOptions options;
  options.robots = 2 + static_cast<std::uint32_t>(random.bits() % 4);
  options.radio = {
      random.uniform() * 0.5, random.uniform() * 0.2, random.uniform() * 0.2, 2'000'000, 5'000'000, 60'000'000, seed};
  options.has_disks = has_disks;
  GossipFleet fleet(options);
  const int events = 5 + static_cast<int>(random.bits() % 20);
  for (int e = 0; e < events; ++e) {
    const auto robot = static_cast<std::uint32_t>(random.bits() % options.robots);
    switch (random.bits() % 8) {
      case 0:
        if (fleet.is_alive(robot)) {
          fleet.kill(robot);
        } else {
          if (has_disks && random.bits() % 8 == 0) fleet.lose_disk(robot);
          fleet.start(robot);
        }
        break;
      case 1:
        fleet.set_group(robot, static_cast<int>(random.bits() % 3));
        break;
      case 2:
        fleet.join_all();
        break;
      default:
        if (fleet.is_alive(robot)) fleet.publish(robot, static_cast<int>(random.bits() % 60), 50);
    }
    fleet.run(static_cast<hal::TimeNs>(random.bits() % 700) * 1'000'000);
  }
  fleet.join_all();
  const GossipFleet::Standing before = fleet.standing();
  const bool equal = fleet.run_until_equal(40 * kSecond_ns);
  if (!equal) {
    for (std::uint32_t i = 0; i < options.robots; ++i) {
      if (fleet.is_alive(i)) UNSCOPED_INFO("robot " << i << " holds " << fleet.standing(i).size() << " records");
    }
  }
  REQUIRE(equal);
  // A whole block may have taken the place of its halves, and halves that of the whole.
  const GossipFleet::Standing after = fleet.standing();
  for (const auto& [key, version] : before) {
    net::Version best = 0;
    for (const net::Part part : {net::Part::whole, net::Part::low_half, net::Part::high_half}) {
      if (const auto it = after.find({key.first, net::with_part(key.second, part)}); it != after.end()) {
        best = std::max(best, it->second);
      }
    }
    CHECK(best >= version);
  }
}

}  // namespace

TEST_CASE("two robots come to hold the same", "[net][gossip]") {
  FleetOptions options;
  options.robots = 2;
  GossipFleet fleet(options);
  fleet.publish(0, 200, 500);
  fleet.publish(1, 30, 500);
  REQUIRE(fleet.run_until_equal(3 * kSecond_ns));
  CHECK(fleet.standing(0).size() > 100);
  CHECK(fleet.standing(0) == fleet.standing(1));
}

TEST_CASE("whatever the radio does, all who hear each other come to hold the same, and nothing is lost",
          "[net][gossip]") {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) check_schedule(seed);
}

TEST_CASE("who keeps its disk goes on where it was, whatever the radio does and whenever its power is cut",
          "[net][gossip]") {
  for (std::uint64_t seed = 1; seed <= 15; ++seed) check_schedule(seed, true);
}

TEST_CASE("a payload that fits no datagram is not published", "[net][gossip]") {
  FleetOptions options;
  options.robots = 1;
  GossipFleet fleet(options);
  const mapper::Bytes payload(net::kMostPayload_bytes + 1, 7);
  CHECK_FALSE(fleet.gossip(0).publish(net::block_record(0, 1, net::Part::whole), net::Lane::rest, payload));
  CHECK(fleet.gossip(0).publish(net::block_record(0, 1, net::Part::whole), net::Lane::rest,
                                mapper::ByteSpan(payload).first(net::kMostPayload_bytes)));
}

TEST_CASE("a thousand schedules", "[net][gossip][slow]") {
  for (std::uint64_t seed = 51; seed <= 1050; ++seed) check_schedule(seed);
}

TEST_CASE("schedules of robots that keep their disks", "[net][gossip][slow]") {
  for (std::uint64_t seed = 51; seed <= 200; ++seed) check_schedule(seed, true);
}

TEST_CASE("a hundred thousand schedules of robots that keep their disks", "[net][gossip][.soak]") {
  for (std::uint64_t seed = 1000; seed < 101000; ++seed) check_schedule(seed, true);
}

TEST_CASE("a hundred thousand schedules", "[net][gossip][.soak]") {
  for (std::uint64_t seed = 1000; seed < 101000; ++seed) check_schedule(seed);
}

TEST_CASE("a robot that has kept its records but not what they complete is told the difference alone",
          "[net][gossip][reconcile]") {
  FleetOptions options;
  options.robots = 2;
  options.store = {8, 1U << 15, std::size_t{4} << 20};
  options.radio.loss = GENERATE(0.0, 0.2);
  GossipFleet fleet(options);
  fleet.publish(0, 20000, 100000);
  REQUIRE(fleet.run_until_equal(60 * kSecond_ns));
  const net::LayerIndex layer = fleet.store(1).find({1, 1});
  std::vector<std::pair<net::StoredRecord, mapper::Bytes>> kept;
  fleet.store(1).for_each(layer, [&](const net::StoredRecord& record) {
    mapper::Bytes payload(record.bytes);
    fleet.store(1).read(record, payload);
    kept.emplace_back(record, payload);
  });
  fleet.kill(1);
  fleet.publish(0, 100, 100000);
  fleet.start(1);
  const net::LayerIndex again = fleet.store(1).find_or_add({1, 1});
  for (const auto& [record, payload] : kept) {
    REQUIRE(fleet.store(1).put(again, record.key, record.version, record.lane, payload) ==
            net::LayerStore::Put::stored);
  }
  fleet.store(1).set_unclaimed(again, true);
  const std::uint64_t sent_before = fleet.sent_bytes();
  REQUIRE(fleet.run_until_equal(20 * kSecond_ns));
  const net::ReconcilerCounts& counts = fleet.gossip(1).reconciler_counts();
  CHECK(counts.ended_equal >= 1);
  CHECK(counts.recovered_records > 0);
  CHECK(counts.asked_symbols <= 2 * counts.differences + 16);
  // 20,000 records are two megabytes.
  CHECK(fleet.sent_bytes() - sent_before < 100'000);
  fleet.publish(0, 10, 100000);
  CHECK(fleet.run_until_equal(5 * kSecond_ns));
}

TEST_CASE("a robot whose layers are dropped is forgotten by all who know of it, and nobody brings it back",
          "[net][gossip]") {
  FleetOptions options;
  options.robots = 4;
  options.radio.loss = 0.2;
  GossipFleet fleet(options);
  for (std::uint32_t i = 0; i < 4; ++i) fleet.publish(i, 100, 300);
  REQUIRE(fleet.run_until_equal(20 * kSecond_ns));
  // The first two have the new key file; the third still tells of the layer, and so does its writer.
  for (const std::uint32_t i : {0U, 1U}) REQUIRE(fleet.store(i).refuse_robot(4));
  fleet.publish(3, 20, 300);
  fleet.publish(0, 20, 300);
  fleet.run(10 * kSecond_ns);
  CHECK(fleet.store(0).digest() == fleet.store(1).digest());
  CHECK(fleet.gossip(0).counts().refused_robots > 0);
  REQUIRE(fleet.store(2).refuse_robot(4));
  fleet.kill(3);
  fleet.run(kSecond_ns);
  REQUIRE(fleet.run_until_equal(10 * kSecond_ns));
  const GossipFleet::Standing all = fleet.standing();
  CHECK(all.size() > 200);
  for (const auto& [record, version] : all) CHECK(record.first.robot != 4);
  for (std::uint32_t i = 0; i < 3; ++i) CHECK_FALSE(fleet.store(i).drop_some(1));
}

TEST_CASE("a million records of which some differ after a restart: symbols within their bound",
          "[net][gossip][reconcile][.soak]") {
  constexpr int kRecords = 1'000'000;
  FleetOptions options;
  options.robots = 2;
  options.store = {4, kRecords + 20'000, std::size_t{48} << 20};
  options.radio.loss = 0.1;
  GossipFleet fleet(options);
  const auto publish = [&](int first, int count) {
    for (int i = first; i < first + count; ++i) {
      const auto lane = static_cast<net::Lane>(i % net::kLanes);
      const mapper::Bytes payload(20, static_cast<std::uint8_t>(i));
      const net::RecordKey key = net::block_record(0, static_cast<std::uint64_t>(i), net::Part::whole);
      REQUIRE(fleet.gossip(0).publish(key, lane, payload));
    }
    fleet.gossip(0).commit(fleet.now_ns());
  };
  fleet.kill(1);
  publish(0, kRecords);
  int next = kRecords;
  std::array<double, 2> few{}, many{};  // symbols, and differences that they found
  for (const int differing : {1, 8, 63, 300, 1000, 4000}) {
    fleet.start(1);
    const net::LayerIndex theirs = fleet.store(0).find({1, 1});
    const net::LayerIndex layer = fleet.store(1).find_or_add({1, 1});
    mapper::Bytes payload;
    fleet.store(0).for_each(theirs, [&](const net::StoredRecord& record) {
      payload.resize(record.bytes);
      fleet.store(0).read(record, payload);
      (void)fleet.store(1).put(layer, record.key, record.version, record.lane, payload);
    });
    fleet.store(1).set_unclaimed(layer, true);
    publish(next, differing);
    next += differing;
    const net::ReconcilerCounts before = fleet.gossip(1).reconciler_counts();
    const std::uint64_t sent_before = fleet.sent_bytes();
    const auto begun = std::chrono::steady_clock::now();
    const hal::TimeNs begun_ns = fleet.now_ns();
    REQUIRE(fleet.run_until_equal(120 * kSecond_ns));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    const net::ReconcilerCounts& after = fleet.gossip(1).reconciler_counts();
    const auto differences = static_cast<double>(after.differences - before.differences);
    const auto symbols = static_cast<double>(after.asked_symbols - before.asked_symbols);
    fmt::print(
        "{} of {} records differ: {} symbols ({:.2f} each), {} bytes sent, {:.1f} s simulated, {:.2f} s computed\n",
        differences, kRecords, symbols, symbols / differences, fleet.sent_bytes() - sent_before,
        static_cast<double>(fleet.now_ns() - begun_ns) * 1e-9, took.count());
    CHECK(differences == differing);
    auto& [all_symbols, all_differences] = differing > 256 ? many : few;
    all_symbols += symbols;
    all_differences += differences;
    // Until it is gone: whoever was told of a layer lately is sent its news without asking.
    fleet.kill(1);
    fleet.run(6 * kSecond_ns);
  }
  CHECK(few[0] <= 1.8 * few[1]);
  CHECK(many[0] <= 1.45 * many[1]);
}

TEST_CASE("data waits while its link has no room, and is neither sent nor taken for lost", "[net][gossip]") {
  struct Narrow final : net::Link {
    bool send(net::Address, mapper::ByteSpan message) override {
      sent.emplace_back(message.begin(), message.end());
      return true;
    }
    [[nodiscard]] bool has_room(net::Address) const override { return is_open; }
    bool is_open = true;
    std::vector<mapper::Bytes> sent;
  };
  const auto options = [](net::RobotId robot) {
    net::GossipOptions of;
    of.self = {robot, 1};
    return of;
  };
  Narrow of_writer, of_reader;
  net::LayerStore written({4, 1U << 10, 1U << 18}), read({4, 1U << 10, 1U << 18});
  net::Gossip writer(options(1), written, of_writer), reader(options(2), read, of_reader);
  hal::TimeNs now_ns = kSecond_ns;
  const auto run = [&](hal::TimeNs duration_ns) {
    for (const hal::TimeNs end_ns = now_ns + duration_ns; now_ns < end_ns; now_ns += kSecond_ns / 100) {
      writer.on_time(now_ns);
      for (const auto& message : std::exchange(of_writer.sent, {})) reader.on_message({1, 1, 1}, message, now_ns);
      reader.on_time(now_ns);
      for (const auto& message : std::exchange(of_reader.sent, {})) writer.on_message({2, 1, 2}, message, now_ns);
    }
  };
  const auto data_sent = [&] {
    return writer.counts().sent_messages[static_cast<std::size_t>(net::MessageKind::data)];
  };
  of_writer.is_open = false;
  const mapper::Bytes payload(60, 7);
  for (std::uint64_t i = 0; i < 100; ++i) {
    REQUIRE(writer.publish(net::block_record(0, i, net::Part::whole), net::Lane::ground, payload));
  }
  writer.commit(now_ns);
  run(3 * kSecond_ns);
  CHECK(data_sent() == 0);
  CHECK(read.digest() != written.digest());
  of_writer.is_open = true;
  run(kSecond_ns / 2);
  CHECK(read.digest() == written.digest());
  // Each record once.
  CHECK(data_sent() <= 8);
}
