// SPDX-License-Identifier: Apache-2.0
// Nothing of what robots share allocates after the start; see allocation_test.cpp.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "net/block_wire.hpp"
#include "net/fleet_radio.hpp"
#include "net/gossip.hpp"
#include "net/merged_map.hpp"
#include "net/pose_payload.hpp"
#include "net/udp_port.hpp"
#include "tests/support/gate_fleet.hpp"
#include "tests/system/counted_malloc.hpp"

using namespace g3d;
using test::allocations;
using test::this_thread_armed;

namespace {

/// A robot as far as sharing goes, in real sockets.
struct SharingRobot {
  SharingRobot(const net::FleetKey& keys, std::uint64_t id, std::unique_ptr<net::UdpPort> its_port)
      : port(std::move(its_port)),
        gate(test::copy_of(keys), {.robot = id, .incarnation = 1}),
        radio(gate, *port),
        store({4, 1U << 10, 1U << 18}),
        gossip(options_of(id), store, radio) {}
  static net::GossipOptions options_of(std::uint64_t id) {
    net::GossipOptions options;
    options.self = {id, 1};
    options.seed = id;
    return options;
  }
  void step(hal::TimeNs now_ns) {
    (void)radio.receive(now_ns, [&](const net::Sender& sender, mapper::ByteSpan message) {
      gossip.on_message(sender, message, now_ns);
    });
    gossip.on_time(now_ns);
  }
  std::unique_ptr<net::UdpPort> port;
  net::DatagramGate gate;
  net::FleetRadio radio;
  net::LayerStore store;
  net::Gossip gossip;
};

/// Three robots whose messages go from hand to hand, one in eight is lost, and nothing of it allocates.
class AllocationFleet {
 public:
  static constexpr std::size_t kRobots = 3;
  AllocationFleet() {
    for (std::size_t i = 0; i < kRobots; ++i) robots_[i] = std::make_unique<Robot>(*this, i);
  }
  void publish(std::size_t i, std::uint64_t block, std::span<const std::uint8_t> payload) {
    (void)robots_[i]->gossip.publish(net::block_record(0, block, net::Part::whole), net::Lane::ground, payload);
    robots_[i]->gossip.commit(now_ns_);
  }
  void place(std::size_t i, const hal::Pose& T_world_submap) {
    const net::PosePayload payload = net::pose_payload(T_world_submap, 0.05F);
    (void)robots_[i]->gossip.publish(net::pose_record(0), net::Lane::ground, payload);
    robots_[i]->gossip.commit(now_ns_);
  }
  void step() {
    now_ns_ += 10'000'000;
    for (std::size_t to = 0; to < kRobots; ++to) {
      robots_[to]->gossip.on_time(now_ns_);
      robots_[to]->merged.update(robots_[to]->store);
    }
    for (std::size_t m = 0; m < count_; ++m) {
      const Message& message = messages_[m];
      for (std::size_t to = 0; to < kRobots; ++to) {
        if (to == message.from || (message.to != net::kEverybody && message.to != to + 1)) continue;
        if (++sent_ % 8 == 0) continue;
        robots_[to]->gossip.on_message({message.from + 1, 1, message.from + 1}, {message.bytes.data(), message.size},
                                       now_ns_);
      }
    }
    count_ = 0;
  }
  [[nodiscard]] std::size_t records(std::size_t i) const { return robots_[i]->store.record_count(); }
  [[nodiscard]] std::uint64_t merged_blocks(std::size_t i) const { return robots_[i]->merged.counts().merged_blocks; }

 private:
  struct Message {
    std::size_t from = 0;
    net::Address to = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, net::kMostMessage_bytes> bytes;
  };
  struct Robot final : net::Link {
    Robot(AllocationFleet& its_fleet, std::size_t its_number)
        : fleet(its_fleet),
          number(its_number),
          store({8, 4096, std::size_t{1} << 20, 512}),
          gossip(
              [&] {
                net::GossipOptions options;
                options.self = {its_number + 1, 1};
                options.seed = its_number;
                options.most_peers = kRobots;
                return options;
              }(),
              store, *this),
          merged({{0.05F}, {4096, 4096, 1024}, {1024, 1024, 256}, 4}) {}
    bool send(net::Address to, mapper::ByteSpan message) override {
      if (fleet.count_ == fleet.messages_.size()) return false;
      Message& place = fleet.messages_[fleet.count_++];
      place.from = number;
      place.to = to;
      place.size = message.size();
      std::copy(message.begin(), message.end(), place.bytes.begin());
      return true;
    }
    AllocationFleet& fleet;
    std::size_t number;
    net::LayerStore store;
    net::Gossip gossip;
    net::MergedMap merged;
  };
  std::vector<Message> messages_{400};
  std::size_t count_ = 0;
  std::uint64_t sent_ = 0;
  hal::TimeNs now_ns_ = 1'000'000'000;
  std::array<std::unique_ptr<Robot>, kRobots> robots_;
};

}  // namespace

TEST_CASE("sharing in real sockets allocates nothing once the robots know each other", "[system][allocation]") {
  const net::FleetKey keys = net::generate_fleet_key();
  net::UdpPortOptions options;
  options.interface = "lo";
  options.port = 0;
  options.group = "239.255.72." + std::to_string(1 + ::getpid() % 250);
  auto port_a = net::UdpPort::open(options), port_b = net::UdpPort::open(options);
  REQUIRE(port_a);
  REQUIRE(port_b);
  SharingRobot a(keys, 1, std::move(port_a).value()), b(keys, 2, std::move(port_b).value());
  hal::TimeNs now_ns = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ns += 10 * hal::kMillisecond_ns;
      if (i % 20 == 0) {
        const std::uint8_t payload[2] = {static_cast<std::uint8_t>(i), 7};
        (void)a.gossip.publish(net::block_record(0, 100 + static_cast<std::uint64_t>(i), net::Part::whole),
                               net::Lane::ground, payload);
        a.gossip.commit(now_ns);
      }
      for (SharingRobot* robot : {&a, &b}) robot->step(now_ns);
    }
  };
  run(300);
  REQUIRE(b.gossip.members().all().size() == 1);
  const std::uint64_t before = b.radio.counts().delivered;
  allocations.store(0);
  this_thread_armed = true;
  run(2000);
  a.port->refresh();
  (void)b.port->wait(0);
  this_thread_armed = false;
  CHECK(allocations.load() == 0);
  CHECK(b.radio.counts().delivered > before + 100);
  run(100);
  CHECK(a.store.digest() == b.store.digest());
}

TEST_CASE("sharing and merging maps allocates nothing after the start, whoever is heard for the first time",
          "[system][allocation][net]") {
  AllocationFleet fleet;
  net::BlockPacker packer;
  mapper::BlockValues values{};
  values.fill(4);  // free
  std::vector<std::vector<std::uint8_t>> payloads;
  for (int i = 0; i < 8; ++i) {
    values[static_cast<std::size_t>(i * 60)] = 28;  // occupied
    for (const net::PackedPart& part : packer.pack_within(values, net::kMostPayload_bytes)) {
      if (part.part == net::Part::whole) payloads.emplace_back(part.bytes.begin(), part.bytes.end());
    }
  }
  REQUIRE(payloads.size() == 8);
  const mapper::BlockKey corner = mapper::block_of({32768, 32768, 32768});
  allocations.store(0);
  this_thread_armed = true;
  for (int i = 0; i < 300; ++i) {
    const auto robot = static_cast<std::size_t>(i % 3);
    fleet.publish(robot, corner + static_cast<std::uint64_t>(i % 40), payloads[static_cast<std::size_t>(i % 8)]);
    if (i % 50 < 3) fleet.place(robot, hal::Pose{{0.01 * i, 0.0, 0.0}});
    fleet.step();
  }
  for (int i = 0; i < 300; ++i) fleet.step();
  this_thread_armed = false;
  CHECK(allocations.load() == 0);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(fleet.records(i) > 100);
    CHECK(fleet.records(i) == fleet.records(0));
    CHECK(fleet.merged_blocks(i) > 100);
  }
}
