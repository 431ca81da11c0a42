// SPDX-License-Identifier: Apache-2.0
// What the way through a broker costs: bytes for each byte of content, as gossip, seals, batches and MQTT leave them;
// how late a change is; and how long sites take to hold the same after the broker was away. A real mosquitto on this
// machine, in real time; needs what scripts/setup installs. `broker_bench bytes`, `latency` or `restart`: that alone.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "tests/net/broker_sites.hpp"
#include "tests/support/broker_process.hpp"

namespace {

using namespace g3d;
using namespace g3d::test;

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
constexpr int kBlocksPerS = 300;
/// Of a changed block, in the mean; see block_wire_bench.
constexpr std::size_t kBlock_bytes = 55;

double seconds(hal::TimeNs duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

/// What the broker says about itself.
class BrokerSays {
 public:
  explicit BrokerSays(const BrokerProcess& broker) {
    hal::MqttSettings settings;
    settings.host = "127.0.0.1";
    settings.port = broker.port();
    settings.client_id = "bench";
    settings.subscriptions = {"$SYS/broker/bytes/received"};
    auto made = hal::MqttClient::make(settings, [this](std::string_view, mapper::ByteSpan payload) {
      received_bytes = std::strtoull(std::string(payload.begin(), payload.end()).c_str(), nullptr, 10);
      ++words;
    });
    client_ = std::move(made).value();
    (void)client_->connect();
  }
  void listen() { (void)client_->serve(true, true); }
  std::uint64_t received_bytes = 0;
  int words = 0;

 private:
  std::unique_ptr<hal::MqttClient> client_;
};

bool wait_for_members(BrokerSites& sites) {
  const std::size_t others = sites.ports.size() - 1;
  return sites.run_until(20 * kSecond_ns, [&] {
    return std::all_of(sites.robots.begin(), sites.robots.end(),
                       [&](const auto& robot) { return robot->gossip.members().all().size() >= others; });
  });
}

void bench_bytes(std::size_t site_count) {
  BrokerProcess broker;
  broker.start();
  SitesSetting setting;
  setting.broker_port = broker.port();
  BrokerSites sites(site_count, 1, setting);
  if (!wait_for_members(sites)) std::abort();
  sites.run(2 * kSecond_ns);
  BrokerSays says(broker);
  const auto until_word = [&] {
    const int words = says.words;
    (void)sites.run_until(5 * kSecond_ns, [&] {
      says.listen();
      return says.words > words;
    });
  };
  const auto radio_bytes = [&] {
    std::uint64_t sum = 0;
    for (const auto& robot : sites.robots) sum += robot->mux().counts(1).sent_bytes;
    return sum;
  };
  const auto messages = [&] {
    std::pair<std::uint64_t, std::uint64_t> sum{0, 0};
    for (const auto& port : sites.ports) {
      sum.first += port->counts().sent_messages;
      sum.second += port->counts().sent_datagrams;
    }
    return sum;
  };
  const auto measure = [&](const char* name, bool publishes) {
    until_word();
    const std::uint64_t broker_before = says.received_bytes, radio_before = radio_bytes();
    const auto messages_before = messages();
    const hal::TimeNs begin_ns = sites.now_ns();
    std::uint64_t blocks = 0;
    while (sites.now_ns() - begin_ns < 20 * kSecond_ns) {
      const double due = publishes ? kBlocksPerS * seconds(sites.now_ns() - begin_ns) : 0.0;
      // As a mapper changes them: at once what a frame changed, ten times a second.
      if (due - static_cast<double>(blocks) >= kBlocksPerS / 10) {
        sites.robots[0]->publish(100 * blocks, kBlocksPerS / 10, kBlock_bytes, sites.now_ns());
        blocks += kBlocksPerS / 10;
      }
      says.listen();
      sites.step();
    }
    until_word();
    const double passed_s = seconds(sites.now_ns() - begin_ns);
    const auto broker_bytes = static_cast<double>(says.received_bytes - broker_before);
    const auto sealed_bytes = static_cast<double>(radio_bytes() - radio_before);
    const auto sent_messages = static_cast<double>(messages().first - messages_before.first);
    const auto datagrams = static_cast<double>(messages().second - messages_before.second);
    fmt::print(
        "{} sites, {}: sealed {:.0f} B/s, into the broker {:.0f} B/s ({:.3f} times), {:.2f} datagrams a message, "
        "{:.1f} bytes more a datagram\n",
        site_count, name, sealed_bytes / passed_s, broker_bytes / passed_s, broker_bytes / sealed_bytes,
        datagrams / sent_messages, (broker_bytes - sealed_bytes) / datagrams);
    if (publishes) {
      const double content = static_cast<double>(blocks * kBlock_bytes * (site_count - 1));
      fmt::print("  for each byte of content and receiver: {:.3f} sealed, {:.3f} into the broker\n",
                 sealed_bytes / content, broker_bytes / content);
    }
  };
  measure("at rest, a beacon in 100 ms", false);
  measure("300 blocks/s", true);
}

void bench_latency(std::size_t robots_each) {
  BrokerProcess broker;
  broker.start();
  SitesSetting setting;
  setting.broker_port = broker.port();
  BrokerSites sites(2, robots_each, setting);
  if (!sites.run_until(20 * kSecond_ns, [&] {
        return std::all_of(sites.robots.begin(), sites.robots.end(),
                           [](const auto& robot) { return robot->gossip.members().all().size() >= 1; });
      })) {
    std::abort();
  }
  for (const auto& robot : sites.robots) robot->publish(0, 10, kBlock_bytes, sites.now_ns());
  if (!sites.run_until_equal(20 * kSecond_ns)) std::abort();
  std::vector<double> late_ms;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const hal::TimeNs begin_ns = sites.now_ns();
    sites.robots[robots_each - 1]->publish(100 + i, 1, kBlock_bytes, begin_ns);
    if (!sites.run_until_equal(10 * kSecond_ns)) std::abort();
    late_ms.push_back(1e3 * seconds(sites.now_ns() - begin_ns));
    sites.run(kSecond_ns / 100 * static_cast<hal::TimeNs>(1 + i % 5));
  }
  std::sort(late_ms.begin(), late_ms.end());
  fmt::print("a change is at all {} robots of two sites after {:.1f} ms (median), {:.1f} ms (p99), {:.1f} ms at most\n",
             2 * robots_each, late_ms[late_ms.size() / 2], late_ms[late_ms.size() * 99 / 100], late_ms.back());
}

void bench_restart(double away_s, int blocks) {
  BrokerProcess broker;
  broker.start();
  SitesSetting setting;
  setting.broker_port = broker.port();
  BrokerSites sites(2, 2, setting);
  for (const auto& robot : sites.robots) robot->publish(0, 10, kBlock_bytes, sites.now_ns());
  if (!sites.run_until_equal(20 * kSecond_ns)) std::abort();
  broker.kill();
  for (int i = 0; i < 4; ++i) {
    const auto robot = static_cast<std::size_t>(i);
    sites.robots[robot]->publish(1000, blocks / 4, kBlock_bytes, sites.now_ns());
  }
  sites.run(static_cast<hal::TimeNs>(1e9 * away_s));
  const std::uint64_t sent_before = sites.robots[0]->mux().counts(1).sent_bytes;
  broker.start();
  const hal::TimeNs begin_ns = sites.now_ns();
  (void)sites.run_until(60 * kSecond_ns,
                        [&] { return sites.ports[0]->is_connected() && sites.ports[1]->is_connected(); });
  const hal::TimeNs joined_ns = sites.now_ns();
  const bool is_equal = sites.run_until_equal(60 * kSecond_ns);
  const auto sent = static_cast<double>(sites.robots[0]->mux().counts(1).sent_bytes - sent_before);
  fmt::print(
      "broker away for {:.0f} s, {} blocks changed meanwhile: both sites connected {:.2f} s after it is back, equal "
      "{:.2f} s later ({}); what one site sent needs {:.2f} s at its 250 kB/s\n",
      away_s, blocks, seconds(joined_ns - begin_ns), seconds(sites.now_ns() - joined_ns),
      is_equal ? "all" : "NOT EQUAL", sent / 250e3);
}

}  // namespace

int main(int argc, char** argv) {
  if (const std::string missing = BrokerProcess::what_is_missing(); !missing.empty()) {
    fmt::print("nothing measured: {}\n", missing);
    return 0;
  }
  const std::string only = argc > 1 ? argv[1] : "";
  if (only.empty() || only == "bytes") {
    bench_bytes(2);
    bench_bytes(4);
  }
  if (only.empty() || only == "latency") {
    bench_latency(1);
    bench_latency(2);
  }
  if (only.empty() || only == "restart") {
    bench_restart(2.0, 400);
    bench_restart(10.0, 10'000);
    bench_restart(30.0, 10'000);
  }
  return 0;
}
