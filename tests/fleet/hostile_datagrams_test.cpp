// SPDX-License-Identifier: Apache-2.0
// A fleet under fire: datagrams of every hostile kind at a robot that shares a map meanwhile. None is applied, and what
// they cost is bounded.
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <thread>

#include "hal/clock.hpp"
#include "hal/linux/cpu_time.hpp"
#include "net/udp_port.hpp"
#include "tests/support/hostile_datagrams.hpp"
#include "tests/support/radio_gossip.hpp"

using namespace g3d;
using test::HostileSender;
using test::MemoryAir;
using test::RadioGossip;

namespace {

constexpr hal::TimeNs kHostileSecond_ns = 1'000'000'000;
constexpr hal::TimeNs kHostileStep_ns = 5'000'000;

/// So that every datagram is opened: what is refused then is so by the seal alone, and the replay window.
net::GateSettings without_limits() {
  constexpr net::TokenRate kNoLimit{1e9, 1e9};
  return {.datagrams = {kNoLimit, kNoLimit, 0.0}};
}

/// Two robots that hear each other.
struct Pair {
  explicit Pair(const net::GateSettings& settings = {})
      : ports{MemoryAir::Port(air, 1001), MemoryAir::Port(air, 1002)} {
    for (std::uint32_t i = 0; i < 2; ++i) {
      robots[i] = std::make_unique<RadioGossip>(ports[i], keys, net::LayerId{i + 1, 1}, settings);
      robots[i]->publish(150, 1000 * (i + std::uint64_t{1}), 0);
    }
    for (int step = 0; step < 1000 && (!are_equal() || step < 200); ++step) pass();
  }
  void pass() {
    now_ns += kHostileStep_ns;
    for (const auto& robot : robots) robot->step(now_ns);
  }
  [[nodiscard]] bool are_equal() const { return robots[0]->store.digest() == robots[1]->store.digest(); }

  net::FleetKey keys = net::generate_fleet_key();
  MemoryAir air;
  std::array<MemoryAir::Port, 2> ports;
  std::array<std::unique_ptr<RadioGossip>, 2> robots;
  hal::TimeNs now_ns = 0;
};

struct Cost {
  std::uint64_t opened_in_vain = 0;
  std::int64_t cpu_ns = 0;
  std::uint64_t steps_equal = 0;  ///< of 5 ms, in which the two held the same
  std::uint64_t steps = 0;
  hal::TimeNs simulated_ns = 0;
};

/// `datagrams` at the second robot, 100 every 5 ms; every tenth of a second the first one has news for it.
Cost fire(Pair& fleet, HostileSender& hostile, std::uint64_t datagrams) {
  Cost cost;
  const hal::TimeNs start_ns = fleet.now_ns;
  std::uint64_t next_key = 50'000;
  for (std::uint64_t sent = 0; sent < datagrams;) {
    fleet.now_ns += kHostileStep_ns;
    if (fleet.now_ns % (kHostileSecond_ns / 10) == 0) fleet.robots[0]->publish(1, ++next_key % 1000, fleet.now_ns);
    fleet.robots[0]->step(fleet.now_ns);
    for (int i = 0; i < 100; ++i, ++sent) fleet.ports[1].inbox.push_back(hostile.next());
    const std::int64_t before_ns = hal::thread_cpu_ns();
    fleet.robots[1]->step(fleet.now_ns);
    cost.cpu_ns += hal::thread_cpu_ns() - before_ns;
    ++cost.steps;
    if (fleet.are_equal()) ++cost.steps_equal;
  }
  cost.simulated_ns = fleet.now_ns - start_ns;
  return cost;
}

/// All that was hostile was refused, and the two go on.
Cost check_under_fire(std::uint64_t datagrams, std::uint64_t seed, bool is_limited) {
  Pair fleet(is_limited ? net::GateSettings{} : without_limits()), foreign;
  REQUIRE(fleet.are_equal());
  REQUIRE(fleet.robots[1]->store.record_count() == 300);
  HostileSender hostile(fleet.air.heard, foreign.air.heard, seed);
  const RadioGossip& victim = *fleet.robots[1];
  const std::uint64_t received_before = victim.radio.counts().received;
  const std::uint64_t delivered_before = victim.gate.counts().delivered;
  const std::uint64_t answered_before = victim.radio.counts().answered_bytes;
  const std::uint64_t opened_before = victim.gate.counts()[net::GateRefusal::forged];
  const std::uint64_t sent_before = fleet.robots[0]->radio.counts().sent;
  Cost cost = fire(fleet, hostile, datagrams);

  CHECK(victim.radio.counts().received - received_before >= datagrams);
  CHECK(victim.radio.counts().received == victim.gate.counts().taken());
  for (const std::uint64_t of_kind : hostile.counts) CHECK(of_kind > datagrams / 10);
  // Not one more than its friend has said has come through, and nothing was said that could not be read.
  CHECK(victim.gate.counts().delivered - delivered_before <= fleet.robots[0]->radio.counts().sent - sent_before);
  CHECK(victim.gossip.members().all().size() == 1);
  CHECK(victim.store.layer_count() == 2);
  for (const std::uint64_t faults : victim.gossip.counts().faults) CHECK(faults == 0);
  // What is decrypted in vain is bounded: by the limit for all strangers, and by what each robot might send.
  // What its friend tells arrives at once meanwhile.
  CHECK(cost.steps_equal * 100 >= cost.steps * 95);
  const double fire_s = static_cast<double>(cost.simulated_ns) * 1e-9;
  const std::uint64_t opened_in_vain = cost.opened_in_vain =
      victim.gate.counts()[net::GateRefusal::forged] - opened_before;
  if (is_limited) {
    CHECK(static_cast<double>(opened_in_vain) < 6100.0 * fire_s + 1500.0);
  } else {
    CHECK(opened_in_vain > datagrams / 4);
  }
  // Nobody is drowned in our answers.
  CHECK(static_cast<double>(victim.radio.counts().answered_bytes - answered_before) < 8000.0 * fire_s + 8000.0);
  for (int step = 0; step < 400 && !fleet.are_equal(); ++step) fleet.pass();
  CHECK(fleet.are_equal());
  CHECK(victim.store.record_count() >= 300);
  return cost;
}

}  // namespace

TEST_CASE("ten thousand hostile datagrams: none is applied", "[net][hostile]") {
  const bool is_limited = GENERATE(true, false);
  INFO((is_limited ? "limited" : "unlimited"));
  (void)check_under_fire(10'000, 1, is_limited);
}

TEST_CASE("a store that nobody writes to is the same to the bit after ten thousand hostile datagrams",
          "[net][hostile]") {
  Pair fleet, foreign;
  HostileSender hostile(fleet.air.heard, foreign.air.heard, 3);
  const std::uint64_t digest = fleet.robots[1]->store.digest();
  for (int step = 0; step < 100; ++step) {
    for (int i = 0; i < 100; ++i) fleet.ports[1].inbox.push_back(hostile.next());
    fleet.pass();
    REQUIRE(fleet.robots[1]->store.digest() == digest);
  }
}

TEST_CASE("a million hostile datagrams: none is applied, and their price is bounded", "[net][hostile][.soak]") {
  const bool is_limited = GENERATE(true, false);
  const Cost cost = check_under_fire(1'000'000, 4, is_limited);
  const double us = static_cast<double>(cost.cpu_ns) / 1e3 / 1e6;
  const double share = static_cast<double>(cost.cpu_ns) / static_cast<double>(cost.simulated_ns);
  WARN(fmt::format("a million at 20,000 a second, {}: {} opened in vain, {:.2f} us each, {:.1f} % of a core",
                   is_limited ? "limited" : "unlimited", cost.opened_in_vain, us, 100.0 * share));
  if (is_limited) CHECK(share < 0.05);
}

TEST_CASE("a flood at a real socket costs a bounded share of a core", "[net][hostile][.soak]") {
  Pair fleet, foreign;
  net::UdpPortOptions options;
  options.port = 0;
  options.address = "127.0.0.1";
  options.multicast = false;
  auto port = net::UdpPort::open(options);
  REQUIRE(port);
  RadioGossip victim(*port.value(), fleet.keys, {3, 1});
  const hal::Ipv4Endpoint at{0x7F000001, port.value()->port()};
  std::atomic<bool> is_over{false};
  std::uint64_t offered = 0;
  std::thread flood([&] {
    HostileSender hostile(fleet.air.heard, foreign.air.heard, 5);
    const auto socket = hal::UdpSocket::open({});
    std::vector<mapper::Bytes> made;
    for (int i = 0; i < 5000; ++i) made.push_back(hostile.next().second);
    while (!is_over.load()) offered += socket.value()->send(at, made[offered % made.size()]) ? 1 : 0;
  });
  hal::RealClock clock;
  const hal::TimeNs start_ns = clock.now();
  const std::int64_t cpu_before_ns = hal::thread_cpu_ns();
  for (hal::TimeNs next_ns = start_ns; clock.now() - start_ns < 5 * kHostileSecond_ns; next_ns += kHostileStep_ns) {
    victim.step(clock.now());
    clock.sleep_until(next_ns);
  }
  const double real_s = static_cast<double>(clock.now() - start_ns) * 1e-9;
  const double share = static_cast<double>(hal::thread_cpu_ns() - cpu_before_ns) * 1e-9 / real_s;
  is_over = true;
  flood.join();
  const net::RadioCounts& counts = victim.radio.counts();
  WARN(fmt::format("{:.0f} a second offered, {:.0f} read: {:.1f} % of a core, {:.2f} us each",
                   static_cast<double>(offered) / real_s, static_cast<double>(counts.received) / real_s, 100.0 * share,
                   share * real_s * 1e6 / static_cast<double>(counts.received)));
  CHECK(counts.delivered == 0);
  CHECK(victim.store.record_count() == 0);
  CHECK(static_cast<double>(counts.received) <= 1.1 * 200.0 * net::FleetRadio::kMostAtOnce * real_s);
  CHECK(share < 0.5);
}
