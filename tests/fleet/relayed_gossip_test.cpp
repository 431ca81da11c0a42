// SPDX-License-Identifier: Apache-2.0
// Three robots with everything that sharing has, in real sockets, with a relay between them that mistreats what they
// say. Time is simulated: on the loopback interface a datagram is there when it was sent.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "net/udp_port.hpp"
#include "tests/support/datagram_relay.hpp"
#include "tests/support/radio_gossip.hpp"

using namespace g3d;
using test::DatagramRelay;
using test::RelayModel;

namespace {

constexpr hal::TimeNs kRelaySecond_ns = 1'000'000'000;
constexpr hal::TimeNs kRelayStep_ns = 10'000'000;

RelayModel rough(std::uint64_t seed) {
  RelayModel model;
  model.radio = {0.2, 0.1, 0.1, 2'000'000, 3'000'000, 60'000'000, seed};
  model.flipped = 0.05;
  model.truncated = 0.05;
  return model;
}

class RelayedFleet {
 public:
  explicit RelayedFleet(const RelayModel& model, std::vector<test::RelayCut> cuts = {})
      : relay(3, model, std::move(cuts)) {
    for (std::uint32_t i = 0; i < robots.size(); ++i) start(i, 1);
  }
  void start(std::uint32_t i, std::uint32_t incarnation) {
    robots[i].reset();
    net::UdpPortOptions options;
    options.port = 0;
    options.address = "127.0.0.1";
    options.multicast = false;
    options.peers = relay.peers_of(i);
    auto port = net::UdpPort::open(options);
    if (!port) FAIL(port.error().text);
    ports[i] = std::move(port).value();
    robots[i] = std::make_unique<test::RadioGossip>(*ports[i], keys, net::LayerId{i + 1, incarnation});
  }
  void run(hal::TimeNs duration_ns) {
    for (const hal::TimeNs end_ns = now_ns + duration_ns; now_ns < end_ns;) step();
  }
  bool run_until_equal(hal::TimeNs limit_ns) {
    for (const hal::TimeNs end_ns = now_ns + limit_ns; now_ns < end_ns && !are_equal();) step();
    return are_equal();
  }
  [[nodiscard]] bool are_equal() const {
    return robots[0]->store.digest() == robots[1]->store.digest() &&
           robots[0]->store.digest() == robots[2]->store.digest();
  }

  net::FleetKey keys = net::generate_fleet_key();
  DatagramRelay relay;
  std::array<std::unique_ptr<net::UdpPort>, 3> ports;
  std::array<std::unique_ptr<test::RadioGossip>, 3> robots;
  hal::TimeNs now_ns = 0;

 private:
  void step() {
    now_ns += kRelayStep_ns;
    relay.pump(now_ns);
    for (const auto& robot : robots) robot->step(now_ns);
  }
};

/// Bits per byte, as far as single bytes tell.
double entropy_bits(std::string_view bytes) {
  std::array<double, 256> counts{};
  for (const char byte : bytes) counts[static_cast<std::uint8_t>(byte)] += 1.0;
  double bits = 0.0;
  for (const double count : counts) {
    const double share = count / static_cast<double>(bytes.size());
    if (share > 0.0) bits -= share * std::log2(share);
  }
  return bits;
}

bool shows_words(std::string_view wire) {
  const std::string_view words = test::RadioGossip::kWords;
  for (std::size_t at = 0; at + 6 <= words.size(); ++at) {
    if (wire.find(words.substr(at, 6)) != std::string_view::npos) return true;
  }
  return false;
}

/// To whom they went, from where they came and from a stranger's address, as fast as robots read. Returns how many
/// messages reached gossip meanwhile.
std::uint64_t replay_all(RelayedFleet& fleet, const std::vector<DatagramRelay::Captured>& capture) {
  const auto delivered = [&] {
    std::uint64_t sum = 0;
    for (const auto& robot : fleet.robots) sum += robot->gate.counts().delivered;
    return sum;
  };
  const auto stranger = hal::UdpSocket::open({});
  REQUIRE(stranger);
  const std::uint64_t before = delivered();
  std::size_t at = 0;
  for (const DatagramRelay::Captured& captured : capture) {
    fleet.relay.replay(captured);
    REQUIRE(stranger.value()->send({0x7F000001, fleet.ports[captured.to]->port()}, captured.datagram));
    if (++at % 50 == 0) fleet.run(kRelayStep_ns);
  }
  fleet.run(kRelaySecond_ns / 10);
  return delivered() - before;
}

}  // namespace

TEST_CASE("three robots in real sockets converge through a relay that mistreats what they say", "[net][relay]") {
  const std::uint64_t seed = GENERATE(1, 2, 3);
  INFO("seed " << seed);
  // The third is cut off from both, then from the first alone: what it needs comes through the second.
  RelayedFleet fleet(rough(seed), {{0, 2, 2 * kRelaySecond_ns, 60 * kRelaySecond_ns},
                                   {1, 2, 2 * kRelaySecond_ns, 5 * kRelaySecond_ns}});
  for (std::uint64_t i = 0; i < 3; ++i) fleet.robots[i]->publish(150, 1000 * (i + 1), 0);
  fleet.run(3 * kRelaySecond_ns);
  for (std::uint64_t i = 0; i < 3; ++i) fleet.robots[i]->publish(50, 1000 * (i + 1) + 100, fleet.now_ns);
  CHECK_FALSE(fleet.are_equal());
  REQUIRE(fleet.run_until_equal(20 * kRelaySecond_ns));
  CHECK(fleet.now_ns < 25 * kRelaySecond_ns);
  CHECK(fleet.robots[2]->store.record_count() == 450);
  // It was a rough way.
  CHECK(fleet.relay.radio().lost() > 30);
  CHECK(fleet.relay.counts().flipped > 5);
  CHECK(fleet.relay.counts().truncated > 5);
  const net::GateCounts counts = fleet.robots[0]->gate.counts();
  CHECK(counts[net::GateRefusal::forged] > 0);
  CHECK(counts[net::GateRefusal::replayed] > 0);
  for (const auto& robot : fleet.robots) {
    for (const std::uint64_t faults : robot->gossip.counts().faults) CHECK(faults == 0);
  }
}

TEST_CASE("the wire shows nothing of what robots say, and all of it once more changes nothing", "[net][relay]") {
  RelayedFleet fleet(rough(4));
  for (std::uint64_t i = 0; i < 3; ++i) fleet.robots[i]->publish(400, 1000 * (i + 1), 0);
  REQUIRE(fleet.run_until_equal(20 * kRelaySecond_ns));
  const std::vector<DatagramRelay::Captured> capture = fleet.relay.capture();

  std::string wire, sealed;
  std::set<std::string> beginnings;
  for (const DatagramRelay::Captured& captured : capture) {
    const std::string text(captured.datagram.begin(), captured.datagram.end());
    wire += text;
    sealed += text.substr(net::kEnvelopeHeader_bytes);
    beginnings.insert(text.substr(net::kEnvelopeHeader_bytes, 16));
  }
  REQUIRE(sealed.size() > 50'000);
  CHECK_FALSE(shows_words(wire));
  CHECK(entropy_bits(sealed) > 7.99);
  // Nor does what is said twice look the same twice: only what goes to two peers does, as one datagram.
  CHECK(beginnings.size() * 2 >= capture.size());
  // It would have been seen.
  std::string said;
  for (const auto& robot : fleet.robots) said += robot->said;
  CHECK(shows_words(said));
  CHECK(entropy_bits(said) < 7.0);

  const std::uint64_t digest = fleet.robots[0]->store.digest();
  fleet.relay.set_model({});
  fleet.run(kRelaySecond_ns);
  // What was lost comes now for the first time, and is no news; what comes once more is not even read.
  (void)replay_all(fleet, capture);
  for (const auto& robot : fleet.robots) CHECK(robot->store.digest() == digest);
  fleet.run(kRelaySecond_ns);  // nothing is under way any more
  const std::size_t said_before = fleet.relay.capture().size();
  const std::uint64_t delivered = replay_all(fleet, capture);
  // What was said meanwhile; most of it is for both of the others.
  CHECK(delivered <= 2 * (fleet.relay.capture().size() - said_before));
  std::uint64_t replayed = 0;
  for (const auto& robot : fleet.robots) {
    const net::GateCounts counts = robot->gate.counts();
    replayed += counts[net::GateRefusal::replayed] + counts[net::GateRefusal::too_old];
    CHECK(robot->store.digest() == digest);
    CHECK(robot->gossip.members().all().size() == 2);
  }
  CHECK(replayed > 2 * capture.size());
  // And the fleet goes on.
  fleet.robots[1]->publish(5, 9000, fleet.now_ns);
  REQUIRE(fleet.run_until_equal(3 * kRelaySecond_ns));
  CHECK(fleet.robots[0]->store.digest() != digest);
}

TEST_CASE("a robot that starts anew is told everything again, whether it begins a new layer or goes on",
          "[net][relay]") {
  const std::uint32_t incarnation = GENERATE(1U, 2U);
  INFO("incarnation " << incarnation);
  RelayedFleet fleet(rough(5));
  fleet.robots[0]->publish(200, 1000, 0);
  fleet.robots[1]->publish(200, 2000, 0);
  if (incarnation == 2) fleet.robots[2]->publish(100, 3000, 0);
  REQUIRE(fleet.run_until_equal(20 * kRelaySecond_ns));
  fleet.start(2, incarnation);
  if (incarnation == 2) fleet.robots[2]->publish(100, 3000, fleet.now_ns);
  CHECK_FALSE(fleet.are_equal());
  REQUIRE(fleet.run_until_equal(20 * kRelaySecond_ns));
  CHECK(fleet.robots[2]->store.record_count() == (incarnation == 2 ? 600 : 400));
  // It is still one robot.
  CHECK(fleet.robots[0]->gossip.members().all().size() == 2);
  fleet.robots[0]->publish(10, 5000, fleet.now_ns);
  CHECK(fleet.run_until_equal(5 * kRelaySecond_ns));
}
