// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_status.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <deque>
#include <memory>
#include <vector>

#include "net/udp_port.hpp"
#include "tests/support/gate_fleet.hpp"

using namespace g3d;
using Catch::Matchers::Contains;

namespace {

/// Two robots whose ports are joined by two queues.
struct StatusPair {
  struct Port final : net::DatagramPort {
    bool send(net::Address, mapper::ByteSpan datagram) override {
      if (peer->is_deaf) return true;
      peer->waiting.emplace_back(datagram.begin(), datagram.end());
      return true;
    }
    std::optional<Received> receive() override {
      if (waiting.empty()) return std::nullopt;
      last = std::move(waiting.front());
      waiting.pop_front();
      return Received{address, last};
    }
    Port* peer = nullptr;
    net::Address address = net::kEverybody;
    std::deque<mapper::Bytes> waiting;
    mapper::Bytes last;
    bool is_deaf = false;
  };
  struct Robot {
    Robot(const net::FleetKey& keys, std::uint64_t robot)
        : gate(test::copy_of(keys), {.robot = robot, .incarnation = 1}),
          radio(gate, port),
          map({robot == 0xC3 ? 0.05F : 0.1F}, {256, 64, 16}),
          sharing(options(robot), map, radio) {}
    static net::SharingOptions options(std::uint64_t robot) {
      net::SharingOptions options;
      options.gossip.self = {robot, 1};
      options.store = {4, 1U << 10, std::size_t{1} << 20};
      return options;
    }
    void round(hal::TimeNs now_ns) {
      (void)radio.receive(now_ns, [&](const net::Sender& sender, mapper::ByteSpan message) {
        sharing.on_message(sender, message, now_ns);
      });
      (void)sharing.on_time_apart(now_ns);
    }
    Port port;
    net::DatagramGate gate;
    net::FleetRadio radio;
    mapper::VoxelMap map;
    net::MapSharing sharing;
  };
  explicit StatusPair(std::uint64_t other = 0xB2) : keys(net::generate_fleet_key()), a(keys, 0xA1), b(keys, other) {
    a.port.peer = &b.port;
    b.port.peer = &a.port;
    a.port.address = net::UdpPort::address_of(0x0A000002, 7177);  // where what A receives comes from
    b.port.address = net::UdpPort::address_of(0x0A000001, 7177);
  }
  void run(int rounds) {
    for (int i = 0; i < rounds; ++i) {
      now_ns += 10'000'000;
      a.round(now_ns);
      b.round(now_ns);
    }
  }
  [[nodiscard]] net::FleetStatus status_of_a() const {
    return net::fleet_status(a.sharing, a.gate, a.radio, 0, now_ns);
  }
  net::FleetKey keys;
  Robot a, b;
  hal::TimeNs now_ns = 1'000'000'000;
};

}  // namespace

TEST_CASE("the status names a layer whose voxels have another size", "[net]") {
  StatusPair pair(0xC3);
  pair.a.sharing.publish_pose({}, pair.now_ns);
  pair.b.sharing.publish_pose({}, pair.now_ns);
  pair.run(400);
  const net::FleetStatus status = pair.status_of_a();
  REQUIRE(status.layers.size() == 2);
  CHECK(status.layers[0].resolution_m == 0.1F);
  CHECK(status.layers[1].resolution_m == 0.05F);
  CHECK(net::layers_of_other_grids(status) == 1);
  CHECK_THAT(net::to_text(status), Contains("its voxels are 0.05 m, ours 0.1 m: it is not merged"));
  CHECK_THAT(net::to_json(status), Contains("\"other_resolution_m\": 0.05"));
}

TEST_CASE("the status says what each robot lacks, and when it holds the same", "[net]") {
  StatusPair pair;
  pair.run(200);  // they know each other
  pair.b.port.is_deaf = true;
  pair.a.sharing.publish_pose({}, pair.now_ns);
  mapper::BlockValues values;
  for (mapper::BlockKey key = 1; key <= 3; ++key) {
    values.fill(static_cast<mapper::Rgbo>(key));
    REQUIRE(pair.a.map.write_block(key, values));
    pair.a.sharing.note_changed(std::array{pair.a.map.find(key)});
  }
  pair.run(60);
  net::FleetStatus status = pair.status_of_a();
  CHECK(status.self == net::LayerId{0xA1, 1});
  REQUIRE(status.layers.size() == 1);
  CHECK(status.layers[0].records == 4);
  CHECK(status.layers[0].upto == 4);
  REQUIRE(status.peers.size() == 1);
  CHECK(status.peers[0].robot == 0xB2);
  CHECK(status.peers[0].state == net::PeerState::alive);
  CHECK_FALSE(status.peers[0].holds_the_same);
  REQUIRE(status.peers[0].layers.size() == 1);
  CHECK(status.peers[0].layers[0].lacks_records == 4);
  CHECK(status.peers[0].layers[0].lacks_bytes == status.bytes);
  CHECK_THAT(net::to_text(status), Contains("00000000000000b2  alive  10.0.0.2:7177") && Contains("lacks 4 records"));

  pair.b.port.is_deaf = false;
  pair.run(300);
  status = pair.status_of_a();
  CHECK(status.peers[0].holds_the_same);
  CHECK(status.peers[0].layers[0].lacks_records == 0);
  CHECK(status.peers[0].layers[0].upto == 4);
  CHECK_THAT(net::to_json(status), Contains("\"holds_the_same\": true") && Contains("\"id\": \"00000000000000b2\""));

  const std::array<std::uint8_t, 80> noise{};
  pair.a.port.waiting.emplace_back(noise.begin(), noise.end());
  pair.run(1);
  CHECK_THAT(net::to_json(pair.status_of_a()), Contains("\"unknown_format\": 1"));
  CHECK_THAT(net::to_text(pair.status_of_a()), Contains("1  unknown_format"));

  pair.b.port.waiting.clear();
  for (int i = 0; i < 600; ++i) {
    pair.now_ns += 10'000'000;
    pair.a.round(pair.now_ns);
  }
  CHECK(pair.status_of_a().peers[0].state == net::PeerState::gone);
  CHECK(pair.status_of_a().peers[0].heard_s > 5.0);
}

TEST_CASE("the status of a large fleet has room in one answer", "[net]") {
  net::FleetStatus status;
  for (std::uint64_t robot = 1; robot <= 64; ++robot) {
    status.layers.push_back({{~robot, 0xFFFFFFFF}, ~0ULL, ~0ULL, ~0U});
    net::PeerStatus& peer = status.peers.emplace_back();
    peer.robot = ~robot;
    peer.address = net::UdpPort::address_of(0xFFFFFFFF, 0xFFFF);
    peer.heard_s = 1.0 / 3.0 * 1e6;
    for (std::uint64_t layer = 1; layer <= 64; ++layer) {
      peer.layers.push_back({{~layer, 0xFFFFFFFF}, true, ~0ULL, ~0ULL, true, ~0U, ~0ULL, true});
    }
  }
  status.gate.by_reason.fill(~0ULL);
  const std::string json = net::to_json(status);
  CHECK(json.size() <= net::kMostStatus_bytes);
  CHECK(net::to_text(status).size() <= net::kMostStatus_bytes);
  CHECK_THAT(json, Contains("\"lines_left_out\": 3856"));
  CHECK_THAT(net::to_text(status), Contains("3856 lines are left out"));
}
