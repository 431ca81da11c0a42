// SPDX-License-Identifier: Apache-2.0
// What sharing a map costs on the air and how long it takes, with robots that publish blocks of chance over a simulated
// radio. Times are simulated, so the machine does not count.
//   gossip_bench [--payload BYTES] [--seeds N]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "tests/support/gossip_fleet.hpp"

using namespace g3d;
using tests::FleetOptions;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
std::size_t payload_bytes = 60;
std::uint64_t seeds = 10;

double seconds(hal::TimeNs ns) { return static_cast<double>(ns) * 1e-9; }

FleetOptions options_for(std::uint32_t robots, double loss, std::uint64_t seed) {
  FleetOptions options;
  options.robots = robots;
  options.radio.loss = loss;
  options.radio.seed = seed;
  options.store = {robots + 4, 1U << 15, std::size_t{8} << 20};
  options.payload_bytes = payload_bytes;
  return options;
}

std::string spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return fmt::format("{:.3f} / {:.3f} / {:.3f}", values.front(), values[values.size() / 2], values.back());
}

/// One robot publishes in rounds, everybody is to have it all: bytes on the air per byte of content and receiver, less
/// 64 per robot and round.
void bytes_per_content(std::uint32_t robots, double loss) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    GossipFleet fleet(options_for(robots, loss, seed));
    fleet.run(3 * kSecond_ns);
    const std::uint64_t before = fleet.sent_bytes();
    const hal::TimeNs start = fleet.now_ns();
    std::size_t content = 0;
    for (int round = 0; round < 30; ++round) {
      content += fleet.publish_scan(0, 300);
      fleet.run(kSecond_ns);
    }
    if (!fleet.run_until_equal(60 * kSecond_ns)) fmt::print("  seed {}: never equal\n", seed);
    const double rounds = seconds(fleet.now_ns() - start) / 0.5;  // beacons
    const double free = 64.0 * robots * rounds;
    ratios.push_back((static_cast<double>(fleet.sent_bytes() - before) - free) /
                     (static_cast<double>(content) * (robots - 1)));
  }
  fmt::print("{} robots, {:.0f} % lost: {} bytes per byte of content and receiver (min/median/max)\n", robots,
             100 * loss, spread(ratios));
}

void time_of_a_change(std::uint32_t robots, double loss) {
  std::vector<double> times;
  GossipFleet fleet(options_for(robots, loss, 5));
  fleet.run(5 * kSecond_ns);
  for (std::uint64_t i = 0; i < 100 * seeds; ++i) {
    fleet.run(static_cast<hal::TimeNs>(fleet.random().bits() % 1000) * 1'000'000);
    const hal::TimeNs start = fleet.now_ns();
    (void)fleet.publish_scan(static_cast<std::uint32_t>(i % robots), 5);
    if (!fleet.run_until_equal(60 * kSecond_ns)) fmt::print("  never equal\n");
    times.push_back(seconds(fleet.now_ns() - start));
  }
  std::sort(times.begin(), times.end());
  fmt::print(
      "{} robots, {:.0f} % lost: a change is everywhere after {:.2f} s (median), {:.2f} (p99), {:.2f} (most) of {}\n",
      robots, 100 * loss, times[times.size() / 2], times[times.size() * 99 / 100], times.back(), times.size());
}

void after_a_partition() {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    GossipFleet fleet(options_for(2, 0.0, seed));
    fleet.run(5 * kSecond_ns);
    fleet.set_group(0, 1);
    std::size_t content = 0;
    for (int i = 0; i < 60; ++i) {
      content += fleet.publish_scan(0, 10000 / 60 + 1);
      fleet.run(kSecond_ns);
    }
    fleet.run(static_cast<hal::TimeNs>(fleet.random().bits() % 1000) * 1'000'000);
    fleet.join_all();
    const hal::TimeNs start = fleet.now_ns();
    if (!fleet.run_until_equal(600 * kSecond_ns)) fmt::print("  never equal\n");
    ratios.push_back(seconds(fleet.now_ns() - start) / (static_cast<double>(content) / 250'000.0));
  }
  fmt::print("after 60 s apart, 10,000 blocks of {} bytes, 2 Mbit/s: {} times what the bytes need\n", payload_bytes,
             spread(ratios));
}

void idle(std::uint32_t robots) {
  GossipFleet fleet(options_for(robots, 0.0, 3));
  (void)fleet.publish_scan(0, 100);
  fleet.run(10 * kSecond_ns);
  const std::uint64_t before = fleet.sent_bytes();
  fleet.run(60 * kSecond_ns);
  fmt::print("{} robots at rest: {:.0f} bytes/s each\n", robots,
             static_cast<double>(fleet.sent_bytes() - before) / 60.0 / robots);
}

/// Everybody explores: 100 blocks a second each, for ten seconds.
void many(std::uint32_t robots) {
  FleetOptions options = options_for(robots, 0.05, 3);
  options.store = {robots + 1, 1U << 17, std::size_t{32} << 20};
  GossipFleet fleet(options);
  fleet.run(5 * kSecond_ns);
  const std::uint64_t before = fleet.sent_bytes();
  for (int round = 0; round < 20; ++round) {
    for (std::uint32_t i = 0; i < robots; ++i) (void)fleet.publish_scan(i, 50);
    fleet.run(kSecond_ns / 2);
  }
  const hal::TimeNs start = fleet.now_ns();
  const std::uint64_t sent = fleet.sent_bytes() - before;
  const bool equal = fleet.run_until_equal(120 * kSecond_ns);
  fmt::print("{} robots exploring: {:.1f} kB/s each, {} {:.2f} s after the last change\n", robots,
             static_cast<double>(sent) / 10.0 / robots / 1000.0, equal ? "equal" : "not equal",
             seconds(fleet.now_ns() - start));
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--payload") == 0) payload_bytes = std::strtoul(argv[i + 1], nullptr, 10);
    if (std::strcmp(argv[i], "--seeds") == 0) seeds = std::strtoul(argv[i + 1], nullptr, 10);
  }
  bytes_per_content(2, 0.0);
  bytes_per_content(4, 0.0);
  bytes_per_content(2, 0.2);
  bytes_per_content(4, 0.2);
  time_of_a_change(4, 0.3);
  after_a_partition();
  for (const std::uint32_t robots : {2U, 4U, 16U, 64U}) idle(robots);
  for (const std::uint32_t robots : {2U, 4U, 8U, 16U, 32U, 64U}) many(robots);
}
