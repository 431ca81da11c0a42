// SPDX-License-Identifier: Apache-2.0
#include "net/map_sharing.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "mapper/align/pose_step.hpp"
#include "mapper/map_hash.hpp"
#include "net/sim_radio.hpp"
#include "tests/support/map_agreement.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/submap_walk.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;

namespace {

/// Two robots, each with a map of its own, over a radio.
struct TwoSharers {
  struct Robot final : net::Link {
    Robot(TwoSharers& of, std::uint32_t its_number, const mapper::VoxelMap& map, bool refines = false,
          bool is_chain = false)
        : both(of), number(its_number) {
      net::SharingOptions options;
      options.is_chain = is_chain;
      options.gossip.bandwidth_Bps = is_chain ? 1e6 : options.gossip.bandwidth_Bps;
      if (refines) options.refine.emplace().is_lockstep = true;
      options.gossip.self = {its_number + 1, 1};
      options.store = {4, 1U << 13, std::size_t{4} << 20};
      sharing = std::make_unique<net::MapSharing>(options, map, *this);
    }
    bool send(net::Address, mapper::ByteSpan message) override {
      both.radio.send(number, net::SimRadio::kEveryStation, message, both.now_ns);
      return true;
    }
    TwoSharers& both;
    std::uint32_t number;
    std::unique_ptr<net::MapSharing> sharing;
    std::uint64_t changed = 0;
  };
  explicit TwoSharers(double loss) : radio(2, {loss, 0.0, 0.0, 2'000'000, 1'000'000, 0, 3}) {}
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ns += 10'000'000;
      radio.deliver(now_ns, [&](std::uint32_t from, std::uint32_t to, mapper::ByteSpan message) {
        robots[to]->sharing->on_message({from + 1, 1, from + 1}, message, now_ns);
      });
      for (auto& robot : robots) robot->changed += robot->sharing->on_time(now_ns).size();
    }
  }
  net::SimRadio radio;
  hal::TimeNs now_ns = 1'000'000'000;
  std::array<std::unique_ptr<Robot>, 2> robots;
};

}  // namespace

TEST_CASE("what one robot has seen comes into the view by which the other drives", "[net]") {
  const double loss = GENERATE(0.0, 0.3);
  const auto room = tests::furnished_room(0.1F);
  mapper::VoxelMap empty(room->grid(), room->capacity());
  TwoSharers both(loss);
  both.robots[0] = std::make_unique<TwoSharers::Robot>(both, 0, *room);
  both.robots[1] = std::make_unique<TwoSharers::Robot>(both, 1, empty);
  both.robots[0]->sharing->publish_pose({}, both.now_ns);
  for (std::uint32_t slot = 0; slot < room->slot_end(); ++slot) both.robots[0]->sharing->note_changed(std::array{slot});
  both.run(600);
  CHECK(mapper::map_hash(both.robots[1]->sharing->view().map()) == mapper::map_hash(*room));
  CHECK(both.robots[1]->changed >= room->sorted_keys().size());
  // Its own layer is no news to who wrote it.
  CHECK(both.robots[0]->changed == 0);
  CHECK(both.robots[0]->sharing->others().submap_count() == 0);
  CHECK(both.robots[0]->sharing->store().digest() == both.robots[1]->sharing->store().digest());
}

TEST_CASE("a robot that comes back sees what it and others had seen, though nobody is there", "[net][keeper]") {
  struct Nobody final : net::Link {
    bool send(net::Address, mapper::ByteSpan) override { return true; }
  } nobody;
  const test::TempFolder folder;
  const auto room = tests::furnished_room(0.1F);
  const mapper::VoxelMap empty(room->grid(), room->capacity());
  net::SharingOptions options;
  options.store = {8, 1U << 13, std::size_t{4} << 20};
  net::KeeperOptions keeper;
  keeper.folder = folder / "layers";
  keeper.robot = 5;
  keeper.has_thread = false;
  net::LayerId self;
  for (int start = 0; start < 3; ++start) {
    auto kept = net::KeptLayers::open(keeper, options.store);
    REQUIRE(kept);
    net::MapSharing sharing(options, start == 0 ? *room : empty, nobody, std::move(kept).value());
    if (start == 0) self = sharing.gossip().options().self;
    CHECK(self.robot == 5);
    CHECK(sharing.gossip().options().self == self);
    hal::TimeNs now_ns = 1'000'000'000;
    sharing.publish_pose({}, now_ns);
    if (start == 0) {
      for (std::uint32_t slot = 0; slot < room->slot_end(); ++slot) sharing.note_changed(std::array{slot});
    }
    for (const hal::TimeNs end_ns = now_ns + 20'000'000'000; now_ns < end_ns; now_ns += 10'000'000) {
      (void)sharing.on_time(now_ns);
    }
    // What it sees itself is no news to it; what it saw before is.
    CHECK(sharing.others().submap_count() == static_cast<std::size_t>(start));
    if (start > 0) CHECK(mapper::map_hash(sharing.view().map()) == mapper::map_hash(*room));
    if (start == 1) {
      // Its own layers stay, whoever is dropped.
      sharing.drop(std::array<net::RobotId, 2>{5, 6});
      CHECK_FALSE(sharing.store().is_refused_robot(5));
      CHECK(sharing.store().is_refused_robot(6));
    }
    // Switched off, or only fallen down.
    if (start == 0) sharing.close();
  }
}

TEST_CASE("a robot that was told wrongly where it is sees what the others have seen where it is",
          "[net][refine][slow]") {
  const bool refines = GENERATE(true, false);
  const auto room = tests::furnished_room(0.1F);
  TwoSharers both(0.1);
  // Both maps stand in the world's frame in truth; the second robot believes otherwise.
  const hal::Pose said = hal::from_xyz_rpy(0.2, -0.15, 0, 0, 0, 0.08);
  for (std::uint32_t i = 0; i < 2; ++i) {
    both.robots[i] = std::make_unique<TwoSharers::Robot>(both, i, *room, refines);
    both.robots[i]->sharing->publish_pose(i == 1 ? said : hal::Pose{}, both.now_ns);
    for (std::uint32_t slot = 0; slot < room->slot_end(); ++slot) {
      both.robots[i]->sharing->note_changed(std::array{slot});
    }
  }
  both.run(1500);
  const net::MapSharing& second = *both.robots[1]->sharing;
  const double agrees = tests::agreement(both.robots[1]->sharing->view().map(), *room).beside();
  const double error_m = mapper::align::shift_of(mapper::align::difference(hal::Pose{}, second.T_world_map()));
  INFO("refined: " << refines << ", agreement " << agrees << ", off " << error_m << " m");
  CHECK((agrees > 0.98) == refines);
  CHECK((error_m < 0.03) == refines);
  CHECK(both.robots[0]->sharing->T_world_map().translation_m == hal::Pose{}.translation_m);
  CHECK(both.robots[0]->sharing->store().digest() == second.store().digest());
}

TEST_CASE("a chain is shared while it grows, what is newer goes ahead, and a correction moves it",
          "[net][chain][slow]") {
  tests::SubmapWalk walk({.most_way_m = 2.0});
  mapper::VoxelMap empty(walk.mapper.map().grid(), tests::kPlentyOfBlocks);
  TwoSharers both(0.1);
  both.robots[0] = std::make_unique<TwoSharers::Robot>(both, 0, walk.mapper.map(), false, true);
  both.robots[1] = std::make_unique<TwoSharers::Robot>(both, 1, empty);
  net::MapSharing& first = *both.robots[0]->sharing;
  const net::MapSharing& second = *both.robots[1]->sharing;
  first.publish_pose({}, both.now_ns);
  const auto settle = [&] {
    for (int i = 0; i < 8; ++i) {
      first.publish_chain(walk.chain, both.now_ns);
      both.run(60);
    }
    REQUIRE(first.chain_writer().is_up_to_date());
    REQUIRE(first.store().digest() == second.store().digest());
  };
  for (int i = 0; i < 25; ++i) {
    walk.go(1);
    first.note_changed(walk.mapper.changed_slots());
    first.publish_chain(walk.chain, both.now_ns);
    both.run(10);
  }
  REQUIRE(walk.chain.submaps().size() >= 2);
  REQUIRE_FALSE(walk.chain.recorder().is_empty());
  settle();
  // In the middle of a stretch, too.
  CHECK(mapper::map_hash(second.others().map()) == mapper::map_hash(walk.mapper.map()));
  REQUIRE(walk.chain.finish_submap());
  settle();
  CHECK(mapper::map_hash(second.others().map()) == mapper::map_hash(walk.mapper.map()));

  std::vector<hal::Pose> poses(walk.chain.submaps().size());
  poses[1].translation_m = {0.1, -0.05, 0.0};
  walk.chain.place(poses);
  walk.chain.rebuild();
  const std::uint64_t chain_bytes = first.chain_writer().counts().published_bytes;
  const std::uint64_t blocks = first.writer().counts().published_blocks;
  settle();
  CHECK(first.chain_writer().counts().published_bytes == chain_bytes + net::kPosePayload_bytes);
  CHECK(first.writer().counts().published_blocks == blocks);
  CHECK(mapper::map_hash(second.others().map()) == mapper::map_hash(walk.mapper.map()));
}
