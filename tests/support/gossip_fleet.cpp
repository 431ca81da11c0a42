// SPDX-License-Identifier: Apache-2.0
#include "tests/support/gossip_fleet.hpp"

#include <algorithm>
#include <array>

namespace g3d::tests {

GossipFleet::Robot::Robot(GossipFleet& of, std::uint32_t its_number, std::uint32_t incarnation)
    : fleet(of),
      number(its_number),
      heard(of.options_.robots, 0),
      store(of.options_.store),
      gossip(
          [&] {
            net::GossipOptions options;
            options.self = {its_number + 1, incarnation};
            options.seed = of.random_.bits();
            options.bandwidth_Bps = of.options_.bandwidth_Bps;
            return options;
          }(),
          store, *this) {}

bool GossipFleet::Robot::send(net::Address to, mapper::ByteSpan message) {
  const std::uint32_t station =
      to == net::kEverybody ? net::SimRadio::kEveryStation : static_cast<std::uint32_t>(to - 1);
  mapper::Bytes datagram;
  mapper::put(datagram, fleet.starts_[number]);
  mapper::put_bytes(datagram, message);
  fleet.radio_.send(number, station, datagram, fleet.now_ns_);
  return true;
}

GossipFleet::GossipFleet(const FleetOptions& options)
    : options_(options),
      groups_(options.robots, 0),
      radio_(options.robots, options.radio,
             [this](std::uint32_t from, std::uint32_t to, hal::TimeNs) { return groups_[from] == groups_[to]; }),
      random_(options.radio.seed * 77 + 5),
      starts_(options.robots, 0),
      robots_(options.robots) {
  for (std::uint32_t i = 0; i < options.robots; ++i) start(i);
}

void GossipFleet::start(std::uint32_t i) { robots_[i] = std::make_unique<Robot>(*this, i, ++starts_[i]); }

void GossipFleet::kill(std::uint32_t i) {
  robots_[i].reset();
  radio_.forget(i);
}

void GossipFleet::step() {
  now_ns_ += options_.step_ns;
  radio_.deliver(now_ns_, [this](std::uint32_t from, std::uint32_t to, mapper::ByteSpan datagram) {
    if (robots_[to] == nullptr) return;
    // As the seals have it: who was heard from a later start is believed nothing from an earlier one.
    std::uint32_t start = 0;
    (void)mapper::ByteReader(datagram).take(start);
    if (start < robots_[to]->heard[from]) return;
    robots_[to]->heard[from] = start;
    robots_[to]->gossip.on_message({from + 1, start, from + 1}, datagram.subspan(sizeof start), now_ns_);
  });
  for (const auto& robot : robots_) {
    if (robot != nullptr) robot->gossip.on_time(now_ns_);
  }
}

void GossipFleet::run(hal::TimeNs duration_ns) {
  for (const hal::TimeNs end = now_ns_ + duration_ns; now_ns_ < end;) step();
}

bool GossipFleet::are_equal() const {
  const Robot* first = nullptr;
  for (const auto& robot : robots_) {
    if (robot == nullptr) continue;
    if (first == nullptr) first = robot.get();
    if (robot->store.digest() != first->store.digest()) return false;
  }
  return true;
}

bool GossipFleet::run_until_equal(hal::TimeNs limit_ns) {
  for (const hal::TimeNs end = now_ns_ + limit_ns; now_ns_ < end;) {
    if (are_equal()) return true;
    step();
  }
  return are_equal();
}

void GossipFleet::publish(std::uint32_t i, int records, std::uint64_t keys) {
  std::array<std::uint8_t, 200> payload{};
  net::Gossip& gossip = robots_[i]->gossip;
  for (int r = 0; r < records; ++r) {
    const auto part = static_cast<net::Part>(random_.bits() % 8 < 6 ? 0 : 1 + random_.bits() % 2);
    const net::RecordKey key = net::block_record(0, 1000 + random_.bits() % keys, part);
    const auto lane = static_cast<net::Lane>(random_.bits() % net::kLanes);
    const std::size_t bytes = 1 + random_.bits() % payload.size();
    for (std::size_t b = 0; b < bytes; ++b) payload[b] = static_cast<std::uint8_t>(random_.bits());
    (void)gossip.publish(key, lane, {payload.data(), bytes});
  }
  gossip.commit(now_ns_);
}

std::size_t GossipFleet::publish_scan(std::uint32_t i, int blocks) {
  std::array<std::uint8_t, 1000> payload{};
  net::Gossip& gossip = robots_[i]->gossip;
  std::size_t sum = 0;
  const std::uint64_t corner = random_.bits() % 20000;
  for (const net::Lane lane : net::kAllLanes) {
    std::uint64_t block = corner + 5000 * static_cast<std::uint64_t>(lane);
    const int of_lane = blocks / 3 + (lane == net::Lane::ground ? blocks % 3 : 0);
    for (int b = 0; b < of_lane; ++b) {
      block += 1 + random_.bits() % 5;
      const std::size_t bytes = options_.payload_bytes / 2 + random_.bits() % (options_.payload_bytes + 1);
      for (std::size_t k = 0; k < bytes; ++k) payload[k] = static_cast<std::uint8_t>(random_.bits());
      if (gossip.publish(net::block_record(0, block, net::Part::whole), lane, {payload.data(), bytes})) sum += bytes;
    }
  }
  gossip.commit(now_ns_);
  return sum;
}

std::size_t GossipFleet::standing_bytes() const {
  std::size_t most = 0;
  for (const auto& robot : robots_) most = std::max(most, robot == nullptr ? 0 : robot->store.payload_bytes());
  return most;
}

std::uint64_t GossipFleet::sent_bytes() const {
  std::uint64_t sum = 0;
  for (const auto& robot : robots_) sum += robot == nullptr ? 0 : robot->gossip.counts().all_sent_bytes();
  return sum;
}

GossipFleet::Standing GossipFleet::standing(std::uint32_t i) const {
  Standing all;
  const net::LayerStore& store = robots_[i]->store;
  for (net::LayerIndex layer = 0; layer < store.layer_count(); ++layer) {
    for (const net::Lane lane : net::kAllLanes) {
      for (auto record = store.first_after(layer, lane, 0); record;
           record = store.first_after(layer, lane, record->version)) {
        all[{store.id(layer), record->key}] = record->version;
      }
    }
  }
  return all;
}

GossipFleet::Standing GossipFleet::standing() const {
  Standing all;
  for (std::uint32_t i = 0; i < robots_.size(); ++i) {
    if (robots_[i] == nullptr) continue;
    for (const auto& [key, version] : standing(i)) all[key] = std::max(all[key], version);
  }
  return all;
}

}  // namespace g3d::tests
