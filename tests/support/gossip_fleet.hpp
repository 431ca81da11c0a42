// SPDX-License-Identifier: Apache-2.0
// Robots that gossip over a simulated radio, for tests: each has a store and publishes blocks of chance. Robots may be
// killed and started anew; what the living hold can be compared.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/disk.hpp"
#include "net/gossip.hpp"
#include "net/layer_keeper.hpp"
#include "net/sim_radio.hpp"
#include "tests/support/temp_folder.hpp"

namespace g3d::tests {

struct FleetOptions {
  std::uint32_t robots = 3;
  net::RadioModel radio;
  net::StoreLimits store{16, 1U << 12, std::size_t{1} << 20};
  double bandwidth_Bps = 250'000.0;
  hal::TimeNs step_ns = 10'000'000;
  std::size_t payload_bytes = 60;  ///< of publish_scan(), in the mean
  bool has_disks = false;          ///< what a robot knows lies in a folder, and is found there by its next start
  std::uint64_t reach = 1000;      ///< robots hear those whose numbers differ by no more
};

class GossipFleet {
 public:
  explicit GossipFleet(const FleetOptions& options);

  /// Lets time pass.
  void run(hal::TimeNs duration_ns);
  /// Until all living robots that `linked` joins hold the same. False if they do not in that time.
  [[nodiscard]] bool run_until_equal(hal::TimeNs limit_ns);
  [[nodiscard]] bool are_equal() const;
  /// Robot `i` publishes so many records: keys below `keys`, lanes and contents by chance.
  void publish(std::uint32_t i, int records, std::uint64_t keys);
  /// So many blocks that neighbour each other, as a scan changes them, in an order by lane and key. Returns the bytes
  /// of their payloads.
  std::size_t publish_scan(std::uint32_t i, int blocks);
  /// With a disk: some or all of what was not synced may be missing there afterwards.
  void kill(std::uint32_t i);
  /// A new start of a robot: as a new incarnation with nothing in memory, or as its disk has it.
  void start(std::uint32_t i);
  /// Nothing of its disk is left. Not while it lives.
  void lose_disk(std::uint32_t i);
  /// Who hears whom: groups that do not hear each other. All the same: everybody.
  void set_group(std::uint32_t i, int group) { groups_[i] = group; }
  [[nodiscard]] int group(std::uint32_t i) const { return groups_[i]; }
  void join_all() { std::fill(groups_.begin(), groups_.end(), 0); }

  [[nodiscard]] bool is_alive(std::uint32_t i) const { return robots_[i] != nullptr; }
  [[nodiscard]] net::Gossip& gossip(std::uint32_t i) { return robots_[i]->gossip; }
  [[nodiscard]] net::LayerStore& store(std::uint32_t i) { return robots_[i]->store; }
  [[nodiscard]] net::LayerKeeper& keeper(std::uint32_t i) { return *robots_[i]->keeper; }
  [[nodiscard]] net::SimRadio& radio() { return radio_; }
  [[nodiscard]] hal::TimeNs now_ns() const { return now_ns_; }
  [[nodiscard]] hal::SeededRandom& random() { return random_; }
  /// Bytes of payloads that robot `i` has published and that still stand.
  [[nodiscard]] std::size_t standing_bytes() const;
  [[nodiscard]] std::uint64_t sent_bytes() const;

  /// Of every record that a living robot holds the highest version: layer and key -> version.
  using Standing = std::map<std::pair<net::LayerId, net::RecordKey>, net::Version>;
  [[nodiscard]] Standing standing() const;
  /// The same of one robot.
  [[nodiscard]] Standing standing(std::uint32_t i) const;

 private:
  struct Robot final : net::Link {
    Robot(GossipFleet& fleet, std::uint32_t number, std::uint32_t incarnation);
    bool send(net::Address to, mapper::ByteSpan message) override;
    GossipFleet& fleet;
    std::uint32_t number;
    std::vector<std::uint32_t> heard;  ///< by robot: from which of its starts
    net::LayerStore store;
    std::unique_ptr<net::LayerKeeper> keeper;
    net::Gossip gossip;
  };
  /// fsync waits for nothing here.
  struct HastyDisk final : hal::Disk {
    [[nodiscard]] int fsync(int) override { return 0; }
  };
  void step();
  [[nodiscard]] std::string folder_of(std::uint32_t i) const;

  FleetOptions options_;
  std::unique_ptr<test::TempFolder> disks_;
  HastyDisk hasty_disk_;
  std::optional<hal::DiskInstead> disk_instead_;
  std::vector<int> groups_;
  net::SimRadio radio_;
  hal::SeededRandom random_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::unique_ptr<Robot>> robots_;
  hal::TimeNs now_ns_ = 1'000'000'000;
};

}  // namespace g3d::tests
