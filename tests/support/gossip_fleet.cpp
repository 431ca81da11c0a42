// SPDX-License-Identifier: Apache-2.0
#include "tests/support/gossip_fleet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

namespace g3d::tests {

GossipFleet::Robot::Robot(GossipFleet& of, std::uint32_t its_number, std::uint32_t incarnation)
    : fleet(of),
      number(its_number),
      heard(of.options_.robots, 0),
      store(of.options_.store),
      keeper([&]() -> std::unique_ptr<net::LayerKeeper> {
        if (!of.options_.has_disks) return nullptr;
        net::KeeperOptions options;
        options.folder = of.folder_of(its_number);
        options.robot = its_number + 1;
        options.ring_bytes = std::size_t{1} << 20;
        options.has_thread = false;
        options.reserve = 500;
        return std::move(net::LayerKeeper::open(options, store)).value();
      }()),
      gossip(
          [&] {
            net::GossipOptions options;
            options.self = keeper ? keeper->self() : net::LayerId{its_number + 1, incarnation};
            options.restored_upto = keeper ? keeper->restored_upto() : 0;
            options.seed = of.random_.bits();
            options.bandwidth_Bps = of.options_.bandwidth_Bps;
            options.most_peers = of.options_.robots;
            return options;
          }(),
          store, *this) {
  if (keeper) gossip.set_version_limit(keeper->version_limit());
}

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
             [this](std::uint32_t from, std::uint32_t to, hal::TimeNs) {
               const std::uint32_t apart = from < to ? to - from : from - to;
               return groups_[from] == groups_[to] && apart <= options_.reach;
             }),
      random_(options.radio.seed * 77 + 5),
      starts_(options.robots, 0),
      robots_(options.robots) {
  if (options.has_disks) {
    disks_ = std::make_unique<test::TempFolder>();
    disk_instead_.emplace(hasty_disk_);
  }
  for (std::uint32_t i = 0; i < options.robots; ++i) start(i);
}

std::string GossipFleet::folder_of(std::uint32_t i) const { return *disks_ / fmt::format("robot{}", i + 1); }

void GossipFleet::lose_disk(std::uint32_t i) { std::filesystem::remove_all(folder_of(i)); }

void GossipFleet::start(std::uint32_t i) { robots_[i] = std::make_unique<Robot>(*this, i, ++starts_[i]); }

void GossipFleet::kill(std::uint32_t i) {
  const std::uint64_t synced_bytes = options_.has_disks ? robots_[i]->keeper->writer().synced_bytes() : 0;
  robots_[i].reset();
  radio_.forget(i);
  if (!options_.has_disks || random_.bits() % 2 == 0) return;
  const std::string journal = folder_of(i) + "/layers.journal";
  const std::uint64_t whole_bytes = std::filesystem::file_size(journal);
  if (whole_bytes <= synced_bytes) return;
  std::filesystem::resize_file(journal, synced_bytes + random_.bits() % (whole_bytes - synced_bytes));
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
    if (robot == nullptr) continue;
    robot->gossip.on_time(now_ns_);
    if (!robot->keeper) continue;
    robot->keeper->on_time(robot->gossip.version(), now_ns_);
    robot->gossip.set_version_limit(robot->keeper->version_limit());
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
