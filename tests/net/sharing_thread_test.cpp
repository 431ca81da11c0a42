// SPDX-License-Identifier: Apache-2.0
#include "net/sharing_thread.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "mapper/block_merge.hpp"
#include "mapper/map_hash.hpp"
#include "net/fleet_key_file.hpp"
#include "tests/support/gate_fleet.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kSharingMs = 1'000'000;
constexpr mapper::MapCapacity kSharingCapacity{4096, 512, 64};

/// Everybody hears everybody; robots are in threads of their own.
class ThreadedAir {
 public:
  class Port final : public net::DatagramPort {
   public:
    Port(ThreadedAir& of, std::size_t its_number) : air_(of), number_(its_number) {}
    bool send(net::Address, mapper::ByteSpan datagram) override {
      const std::lock_guard lock(air_.mutex_);
      for (const auto& port : air_.ports_) {
        if (port.get() != this) port->waiting_.push_back({number_ + 1, {datagram.begin(), datagram.end()}});
      }
      return true;
    }
    std::optional<Received> receive() override {
      const std::lock_guard lock(air_.mutex_);
      if (waiting_.empty()) return std::nullopt;
      last_ = std::move(waiting_.front());
      waiting_.pop_front();
      return Received{last_.first, last_.second};
    }

   private:
    ThreadedAir& air_;
    std::size_t number_;
    std::deque<std::pair<net::Address, mapper::Bytes>> waiting_;
    std::pair<net::Address, mapper::Bytes> last_;
  };
  Port& add() {
    const std::lock_guard lock(mutex_);
    return *ports_.emplace_back(std::make_unique<Port>(*this, ports_.size()));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Port>> ports_;
};

struct SharingRobot {
  SharingRobot(ThreadedAir& air, const net::FleetKey& keys, std::uint64_t robot, bool has_map = true,
               const std::string& key_path = {}, const hal::Pose& T_world_map = {},
               std::unique_ptr<net::KeptLayers> kept = nullptr)
      : own({0.1F}, kSharingCapacity),
        port(air.add()),
        thread(options(robot, has_map, key_path, T_world_map), test::copy_of(keys), parts(), std::move(kept)) {}

  static net::SharingThreadOptions options(std::uint64_t robot, bool has_map, const std::string& key_path,
                                           const hal::Pose& T_world_map) {
    net::SharingThreadOptions options;
    options.has_map = has_map;
    options.key_path = key_path;
    options.wait_ns = 2 * kSharingMs;
    options.sharing.gossip.self = {robot, 1};
    options.sharing.gossip.seed = robot;
    options.sharing.gossip.bandwidth_Bps = 5e6;
    options.sharing.gossip.beacon_period_ns = 100 * kSharingMs;
    options.sharing.gossip.membership = {400 * kSharingMs, 800 * kSharingMs};
    options.key_period_ns = 50 * kSharingMs;
    options.sharing.store = {8, 1U << 13, std::size_t{4} << 20};
    options.sharing.round_ns = 50 * kSharingMs;
    options.sharing.merge_every_ns = 20 * kSharingMs;
    options.sharing.T_world_map = T_world_map;
    return options;
  }
  net::SharingParts parts() {
    net::SharingParts parts{port, [this](hal::TimeNs at_most_ns) { clock.sleep_until(clock.now() + at_most_ns); },
                            clock, own};
    parts.on_round = [this](net::MapSharing&, hal::TimeNs) { rounds.fetch_add(1, std::memory_order_relaxed); };
    return parts;
  }
  /// As the mapper does it.
  void see(mapper::BlockKey key, std::uint8_t level) {
    mapper::BlockValues values;
    values.fill(level);
    REQUIRE(own.write_block(key, values));
    thread.note_changed(std::array{own.find(key)});
  }
  bool becomes_true(const std::function<bool()>& condition) {
    const hal::TimeNs end_ns = clock.now() + 20'000 * kSharingMs;  // for sanitizers on a busy machine
    while (!condition()) {
      if (clock.now() >= end_ns) return false;
      clock.sleep_until(clock.now() + 2 * kSharingMs);
    }
    return true;
  }

  hal::RealClock clock;
  mapper::VoxelMap own;
  ThreadedAir::Port& port;
  std::atomic<int> rounds{0};
  net::SharingThread thread;
};

std::string merged_hash_of(const net::SharingThread& thread) {
  net::MergedOptions options;
  options.grid = {0.1F};
  options.merged = options.submap = kSharingCapacity;
  net::MergedMap merged(options);
  merged.take_all(thread.sharing().store());
  return mapper::map_hash(merged.map());
}

}  // namespace

TEST_CASE("robots in threads share their maps as they grow, and a base station merges them", "[net][threads]") {
  const net::FleetKey keys = net::generate_fleet_key();
  ThreadedAir air;
  SharingRobot a(air, keys, 0xA1), b(air, keys, 0xB2), station(air, keys, 0xC3, false);
  for (SharingRobot* robot : {&a, &b, &station}) robot->thread.start();
  for (mapper::BlockKey key = 1; key <= 200; ++key) {
    a.see(key, 10);
    b.see(key + 100, 12);
    if (key % 20 == 0) a.clock.sleep_until(a.clock.now() + 5 * kSharingMs);
    (void)b.thread.view().take_news();
  }
  // B's view gets what A has seen, and no other thread's help is needed for that.
  REQUIRE(b.becomes_true([&] {
    (void)b.thread.view().take_news();
    return b.thread.view().map().find(50) != mapper::kNoSlot && b.thread.view().map().find(99) != mapper::kNoSlot;
  }));
  net::SharingBrief brief;
  REQUIRE(station.becomes_true([&] {
    (void)station.thread.brief().read(brief);
    return brief.alive == 2 && brief.is_told && brief.records == 402;
  }));
  for (SharingRobot* robot : {&a, &b}) {
    REQUIRE(robot->becomes_true([&] { return robot->thread.brief().read(brief) > 0 && brief.is_told; }));
  }
  const auto status = station.thread.ask();
  REQUIRE(status);
  CHECK(status->peers.size() == 2);
  CHECK(status->layers.size() == 3);
  for (const net::PeerStatus& peer : status->peers) CHECK(peer.holds_the_same);
  for (SharingRobot* robot : {&a, &b, &station}) {
    robot->thread.stop();
    robot->thread.stop();  // changes nothing
    CHECK(robot->rounds > 0);
  }
  CHECK(merged_hash_of(a.thread) == merged_hash_of(b.thread));
  CHECK(merged_hash_of(a.thread) == mapper::map_hash(station.thread.others()));
  CHECK(station.thread.sharing().writer().counts().published_blocks == 0);
  CHECK_FALSE(station.thread.ask());  // nobody is there to answer
}

TEST_CASE("others' maps come into the frame of a robot that began elsewhere", "[net][threads]") {
  const net::FleetKey keys = net::generate_fleet_key();
  ThreadedAir air;
  // A's map lies 1.6 m farther along x than the world, two blocks of 0.8 m; B's is the world's.
  SharingRobot a(air, keys, 0xA1, true, {}, hal::from_xyz_rpy(1.6, 0, 0, 0, 0, 0)), b(air, keys, 0xB2);
  a.thread.start();
  b.thread.start();
  const mapper::VoxelIndex at{32768, 32768, 32768};
  const mapper::VoxelIndex two_on{32768 + 16, 32768, 32768};
  b.see(mapper::encode(two_on) >> 9, 14);
  REQUIRE(a.becomes_true([&] {
    (void)a.thread.view().take_news();
    return mapper::level_of(a.thread.view().map().at(at)) == 14;
  }));
  CHECK(a.thread.view().map().at(two_on) == mapper::kUnknownRgbo);
}

TEST_CASE("a key that is rotated on disk is taken over while robots run, and a bad file is not", "[net][threads]") {
  const test::TempFolder folder;
  net::FleetKey keys = net::generate_fleet_key();
  const std::string of_a = folder / "a.key";
  const std::string of_b = folder / "b.key";
  for (const std::string& path : {of_a, of_b}) REQUIRE(net::write_fleet_key(path, keys));
  ThreadedAir air;
  SharingRobot a(air, keys, 0xA1, true, of_a), b(air, keys, 0xB2, true, of_b);
  a.thread.start();
  b.thread.start();
  net::SharingBrief brief;
  REQUIRE(a.becomes_true([&] { return a.thread.brief().read(brief) > 0 && brief.alive == 1; }));
  // B is in wrong hands: only A gets the new key.
  net::rotate_fleet_key(keys, net::OldKey::shut_out);
  REQUIRE(net::write_fleet_key(of_a, keys));
  // In one piece, as keys are written: the file might be looked at while it is empty, which counts as well.
  test::write_plain(of_b + ".new", "no key\n");
  std::filesystem::rename(of_b + ".new", of_b);
  REQUIRE(a.becomes_true([&] { return a.thread.brief().read(brief) > 0 && brief.epoch == 2; }));
  REQUIRE(a.becomes_true([&] { return a.thread.brief().read(brief) > 0 && brief.alive == 0; }));
  const auto shut_out = a.thread.ask();
  REQUIRE(shut_out);
  CHECK(shut_out->gate[net::GateRefusal::unknown_epoch] > 0);
  REQUIRE(b.becomes_true([&] {
    const auto status = b.thread.ask();
    return status && status->rejected_keys == 1;
  }));
  REQUIRE(b.thread.brief().read(brief) > 0);
  CHECK(brief.epoch == 1);
  // It is found and gets the key after all.
  REQUIRE(net::write_fleet_key(of_b, keys));
  REQUIRE(a.becomes_true([&] { return a.thread.brief().read(brief) > 0 && brief.alive == 1; }));
}

TEST_CASE("a robot that keeps its layers goes on with them after a restart", "[net][threads]") {
  const test::TempFolder folder;
  const net::FleetKey keys = net::generate_fleet_key();
  const auto kept_in = [&] {
    net::KeeperOptions options;
    options.folder = folder / "layers";
    options.robot = 0xA1;
    auto kept = net::KeptLayers::open(options, {8, 1U << 13, std::size_t{4} << 20});
    REQUIRE(kept);
    return std::move(kept).value();
  };
  ThreadedAir air;
  net::LayerId self;
  {
    SharingRobot first(air, keys, 0xA1, true, {}, {}, kept_in());
    first.thread.start();
    for (mapper::BlockKey key = 1; key <= 20; ++key) first.see(key, 10);
    net::SharingBrief brief;
    REQUIRE(first.becomes_true([&] {
      (void)first.thread.brief().read(brief);
      return brief.records == 21;
    }));
    first.thread.stop();
    self = first.thread.status().self;
  }
  SharingRobot again(air, keys, 0xA1, true, {}, {}, kept_in()), other(air, keys, 0xB2);
  CHECK(again.thread.status().self == self);
  CHECK(again.thread.sharing().store().record_count() == 21);
  again.thread.start();
  other.thread.start();
  again.see(100, 12);
  REQUIRE(other.becomes_true([&] {
    (void)other.thread.view().take_news();
    const mapper::VoxelMap& map = other.thread.view().map();
    return map.find(100) != mapper::kNoSlot && map.find(1) != mapper::kNoSlot && map.find(20) != mapper::kNoSlot;
  }));
}
