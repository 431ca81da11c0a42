// SPDX-License-Identifier: Apache-2.0
// Three robots in three network namespaces, as three machines at one access point: a bridge, multicast, addresses of
// their own, the same port for all, a fifth of all datagrams lost on arrival, and a radio that goes down and comes
// back.
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <string>

#include "hal/clock.hpp"
#include "hal/sim/seeded_random.hpp"
#include "net/udp_port.hpp"
#include "tests/support/own_network.hpp"
#include "tests/support/radio_gossip.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kNetworkStep_ns = 5'000'000;
constexpr hal::TimeNs kNetworkPatience_ns = 15'000'000'000;

bool does(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

/// A network that the calling thread may enter; it lasts as long as this.
class Network {
 public:
  Network() {
    REQUIRE(::unshare(CLONE_NEWNET) == 0);
    fd_ = ::open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    REQUIRE(fd_ >= 0);
  }
  ~Network() { ::close(fd_); }
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;
  void enter() const { REQUIRE(::setns(fd_, CLONE_NEWNET) == 0); }
  [[nodiscard]] std::string path() const { return fmt::format("/proc/{}/fd/{}", ::getpid(), fd_); }

 private:
  int fd_ = -1;
};

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
  Network network;
  std::unique_ptr<net::UdpPort> port;
  std::unique_ptr<LossyPort> lossy;
  std::unique_ptr<test::RadioGossip> robot;
};

class AccessPoint {
 public:
  /// False: this system has no bridges.
  [[nodiscard]] bool build() {
    bridge_.enter();
    if (!does("ip link add ap type bridge mcast_snooping 0 && ip link set ap up")) return false;
    for (std::size_t i = 0; i < machines.size(); ++i) {
      bridge_.enter();
      if (!does(fmt::format("ip link add to{0} type veth peer name radio netns {1} && ip link set to{0} master ap up",
                            i, machines[i].network.path()))) {
        return false;
      }
      machines[i].network.enter();
      REQUIRE(
          does(fmt::format("ip link set lo up && ip addr add 10.77.0.{}/24 dev radio && ip link set radio up", i + 1)));
    }
    return true;
  }
  void start(std::size_t i, const net::FleetKey& keys) {
    Machine& machine = machines[i];
    machine.network.enter();
    net::UdpPortOptions options;
    options.needs_port = true;
    auto port = net::UdpPort::open(options);
    if (!port) FAIL(port.error().text);
    machine.port = std::move(port).value();
    machine.lossy = std::make_unique<LossyPort>(*machine.port, 0.2, i + 1);
    machine.robot = std::make_unique<test::RadioGossip>(*machine.lossy, keys, net::LayerId{i + 1, 1});
  }
  void set_radio_up(std::size_t i, bool is_up) {
    machines[i].network.enter();
    REQUIRE(test::set_interface_up("radio", is_up));
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
  Network bridge_;
};

}  // namespace

TEST_CASE("three robots in networks of their own find each other and converge, though a radio goes down for a while",
          "[system][netns]") {
  if (!does("ip -V")) {
    WARN("skipped: there is no `ip` here (Debian: iproute2)");
    return;
  }
  (void)test::in_own_network([] {
    AccessPoint place;
    if (!place.build()) {
      WARN("skipped: this system has no bridges or veth pairs");
      return;
    }
    const net::FleetKey keys = net::generate_fleet_key();
    for (std::size_t i = 0; i < 3; ++i) {
      place.start(i, keys);
      place.machines[i].robot->publish(150, 1000 * (i + 1), place.clock.now());
    }
    REQUIRE(place.run_until_equal());
    CHECK(place.machines[0].robot->store.record_count() == 450);
    for (const net::Peer& peer : place.machines[0].robot->gossip.members().all()) {
      CHECK(net::UdpPort::text_of(peer.address) == fmt::format("10.77.0.{}:7177", peer.robot));
    }
    place.set_radio_up(2, false);
    place.run(200'000'000);
    for (std::size_t i = 0; i < 3; ++i) place.machines[i].robot->publish(20, 5000 * (i + 1), place.clock.now());
    place.run(1'300'000'000);
    CHECK_FALSE(place.are_equal());
    CHECK(place.machines[0].robot->store.digest() == place.machines[1].robot->store.digest());
    const net::UdpPortCounts down = place.machines[2].port->counts();
    CHECK(down.own.unreachable + down.nowhere > 0);
    CHECK(down.multicast.left == 1);
    place.set_radio_up(2, true);
    REQUIRE(place.run_until_equal());
    CHECK(place.machines[2].port->counts().multicast.joined >= 2);
    CHECK(place.machines[0].robot->store.record_count() == 510);
    for (const Machine& machine : place.machines) CHECK(machine.lossy->lost > 5);
  });
}
