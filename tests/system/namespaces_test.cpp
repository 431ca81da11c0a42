// SPDX-License-Identifier: Apache-2.0
// Three robots in three network namespaces, as three machines at one access point: a bridge, multicast, addresses of
// their own, the same port for all, a fifth of all datagrams lost on arrival, and a radio that goes down and comes
// back.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "hal/clock.hpp"
#include "hal/sim/seeded_random.hpp"
#include "net/udp_port.hpp"
#include "tests/support/access_point.hpp"
#include "tests/support/radio_gossip.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kNetworkStep_ns = 5'000'000;
constexpr hal::TimeNs kNetworkPatience_ns = 15'000'000'000;

/// Loses a share of what comes.
class LossyPort final : public net::DatagramPort {
 public:
  LossyPort(net::DatagramPort& port, double loss, std::uint64_t seed) : port_(port), loss_(loss), random_(seed) {}
  bool send(net::Address to, mapper::ByteSpan datagram) override { return port_.send(to, datagram); }
  std::optional<Received> receive() override {
    for (;;) {
      const auto received = port_.receive();
      if (!received || !random_.happens(loss_)) return received;
      ++lost;
    }
  }
  std::uint64_t lost = 0;

 private:
  net::DatagramPort& port_;
  const double loss_;
  hal::SeededRandom random_;
};

struct Machine {
  std::unique_ptr<net::UdpPort> port;
  std::unique_ptr<LossyPort> lossy;
  std::unique_ptr<test::RadioGossip> robot;
};

class NetworkedFleet {
 public:
  void start(const test::AccessPoint& place, std::size_t i, const net::FleetKey& keys) {
    Machine& machine = machines[i];
    place.enter(i);
    net::UdpPortOptions options;
    options.needs_port = true;
    auto port = net::UdpPort::open(options);
    if (!port) FAIL(port.error().text);
    machine.port = std::move(port).value();
    machine.lossy = std::make_unique<LossyPort>(*machine.port, 0.2, i + 1);
    machine.robot = std::make_unique<test::RadioGossip>(*machine.lossy, keys, net::LayerId{i + 1, 1});
    machine.robot->publish(150, 1000 * (i + 1), clock.now());
  }
  void run(hal::TimeNs duration_ns) {
    for (const hal::TimeNs end_ns = clock.now() + duration_ns; clock.now() < end_ns;) step();
  }
  [[nodiscard]] bool run_until_equal() {
    for (const hal::TimeNs end_ns = clock.now() + kNetworkPatience_ns; clock.now() < end_ns && !are_equal();) step();
    return are_equal();
  }
  [[nodiscard]] bool are_equal() const {
    const auto digest = [&](std::size_t i) { return machines[i].robot->store.digest(); };
    return digest(0) == digest(1) && digest(0) == digest(2);
  }

  hal::RealClock clock;
  std::array<Machine, 3> machines;

 private:
  void step() {
    for (const Machine& machine : machines) machine.robot->step(clock.now());
    clock.sleep_until(clock.now() + kNetworkStep_ns);
  }
};

}  // namespace

TEST_CASE("three robots in networks of their own find each other and converge, though a radio goes down for a while",
          "[system][netns][waits]") {
  (void)test::in_own_network([] {
    const test::AccessPoint place(3);
    if (!place.build()) return;
    NetworkedFleet fleet;
    const net::FleetKey keys = net::generate_fleet_key();
    for (std::size_t i = 0; i < 3; ++i) fleet.start(place, i, keys);
    REQUIRE(fleet.run_until_equal());
    const test::RadioGossip& first = *fleet.machines[0].robot;
    CHECK(first.store.record_count() == 450);
    for (const net::Peer& peer : first.gossip.members().all()) {
      CHECK(net::UdpPort::text_of(peer.address) == fmt::format("10.77.0.{}:7177", peer.robot));
    }
    place.set_radio_up(2, false);
    fleet.run(200'000'000);
    for (std::size_t i = 0; i < 3; ++i) fleet.machines[i].robot->publish(20, 5000 * (i + 1), fleet.clock.now());
    fleet.run(1'300'000'000);
    CHECK_FALSE(fleet.are_equal());
    CHECK(first.store.digest() == fleet.machines[1].robot->store.digest());
    const net::UdpPortCounts down = fleet.machines[2].port->counts();
    CHECK(down.own.unreachable + down.nowhere > 0);
    CHECK(down.multicast.left == 1);
    place.set_radio_up(2, true);
    REQUIRE(fleet.run_until_equal());
    CHECK(fleet.machines[2].port->counts().multicast.joined >= 2);
    CHECK(first.store.record_count() == 510);
    for (const Machine& machine : fleet.machines) CHECK(machine.lossy->lost > 5);
  });
}
