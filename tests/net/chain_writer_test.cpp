// SPDX-License-Identifier: Apache-2.0
// A chain of submaps as a layer: who receives it has the map that its writer has.
#include "net/chain_writer.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "mapper/map_hash.hpp"
#include "net/merged_map.hpp"
#include "tests/support/gossip_fleet.hpp"
#include "tests/support/submap_walk.hpp"

using namespace g3d;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kChainSecond_ns = 1'000'000'000;
constexpr net::LayerId kChainLayer{1, 1};

tests::FleetOptions writer_and_reader() {
  tests::FleetOptions options;
  options.robots = 2;
  options.store = {4, 1U << 15, std::size_t{16} << 20, 1U << 14};
  options.radio.loss = 0.1;
  options.bandwidth_Bps = 1e6;
  return options;
}

/// One robot walks, the other is told.
struct ToldWalk {
  explicit ToldWalk(int steps)
      : walk({.most_way_m = 2.0}),
        fleet(writer_and_reader()),
        writer(fleet.gossip(0), fleet.store(0), walk.chain.view().grid()),
        merged({walk.chain.view().grid(), tests::kPlentyOfBlocks, tests::kPlentyOfBlocks, 32}) {
    walk.go(steps);
    (void)walk.chain.finish_submap();
  }
  std::size_t tell() {
    std::size_t bytes = 0;
    do {
      bytes +=
          writer.publish_round(walk.chain, net::Placement::as_said(T_world_map, kChainLayer), 30000, fleet.now_ns());
      fleet.run(kChainSecond_ns / 20);
    } while (!writer.is_up_to_date());
    REQUIRE(fleet.run_until_equal(60 * kChainSecond_ns));
    merged.update(fleet.store(1));
    REQUIRE(merged.counts().refused_blocks == 0);
    REQUIRE(merged.counts().refused_submaps == 0);
    return bytes;
  }
  /// What the chain says where it stands, the newest first, walls closed: as layers are merged.
  [[nodiscard]] std::string expected() const {
    const mapper::VoxelMap& view = walk.chain.view();
    std::vector<mapper::MapSampler> samplers;
    std::vector<mapper::BlockKey> keys;
    for (std::size_t i = walk.chain.submaps().size(); i-- > 0;) {
      const mapper::submaps::Submap& submap = walk.chain.submaps()[i];
      samplers.emplace_back(*submap.contents->get().voxels, hal::compose(T_world_map, submap.T_world_stored),
                            view.grid(), hal::Pose{}, mapper::Walls::closed);
      samplers.back().add_target_keys(keys);
    }
    mapper::sort_and_drop_repeats(keys);
    mapper::VoxelMap map(view.grid(), tests::kPlentyOfBlocks);
    mapper::BlockValues values;
    mapper::BlockValues older;
    for (const mapper::BlockKey key : keys) {
      values.fill(mapper::kUnknownRgbo);
      for (mapper::MapSampler& sampler : samplers) {
        if (!sampler.sample(key, older)) continue;
        for (std::size_t i = 0; i < values.size(); ++i) {
          if (mapper::state_of(values[i]) == mapper::State::unknown) values[i] = older[i];
        }
      }
      if (mapper::is_known(values)) REQUIRE(map.write_block(key, values));
    }
    return mapper::map_hash(map);
  }

  tests::SubmapWalk walk;
  GossipFleet fleet;
  net::ChainWriter writer;
  net::MergedMap merged;
  hal::Pose T_world_map;
};

}  // namespace

TEST_CASE("a chain of submaps travels, and is its writer's map to the bit", "[net][chain][slow]") {
  ToldWalk told(40);
  const std::size_t submaps = told.walk.chain.submaps().size();
  REQUIRE(submaps >= 3);
  const std::size_t all_bytes = told.tell();
  CHECK(told.merged.submap_count() == submaps);
  CHECK(mapper::map_hash(told.merged.map()) == mapper::map_hash(told.walk.chain.view()));

  // A loop moves one submap by whole voxels: its writer's own map moves the same way.
  std::vector<hal::Pose> poses(submaps);
  poses[1].translation_m = {0.1, -0.05, 0.0};
  told.walk.chain.place(poses);
  told.walk.chain.rebuild();
  const std::uint64_t blocks = told.writer.counts().published_blocks;
  CHECK(told.tell() == net::kPosePayload_bytes);
  CHECK(mapper::map_hash(told.merged.map()) == mapper::map_hash(told.walk.chain.view()));

  // Then all of them, askew, and the layer as a whole.
  for (std::size_t i = 0; i < submaps; ++i)
    poses[i] = hal::from_xyz_rpy(0.01 * static_cast<double>(i), 0.02, 0, 0, 0, 0.01 * static_cast<double>(i));
  told.walk.chain.place(poses);
  told.T_world_map = hal::from_xyz_rpy(1.0, -2.0, 0.0, 0.0, 0.0, 0.5);
  const std::uint64_t sent = told.fleet.sent_bytes();
  const std::size_t pose_bytes = told.tell();
  CHECK(pose_bytes == submaps * net::kPosePayload_bytes);
  INFO("all " << all_bytes << " bytes, poses " << pose_bytes << ", on the air " << told.fleet.sent_bytes() - sent);
  CHECK(told.fleet.sent_bytes() - sent < all_bytes / 20);
  CHECK(told.writer.counts().published_blocks == blocks);
  CHECK(mapper::map_hash(told.merged.map()) == told.expected());
}

TEST_CASE("submaps that are joined are published as one, and others that are new go on", "[net][chain][slow]") {
  ToldWalk told(40);
  (void)told.tell();
  const std::size_t submaps = told.walk.chain.submaps().size();
  (void)told.walk.chain.join(0);
  told.walk.go(20);
  (void)told.walk.chain.finish_submap();
  REQUIRE(told.walk.chain.submaps().size() > submaps - 1);
  (void)told.tell();
  CHECK(told.writer.counts().retracted_submaps == 1);
  CHECK(mapper::map_hash(told.merged.map()) == mapper::map_hash(told.walk.chain.view()));
  // Told once, nothing more is to be told.
  CHECK(told.tell() == 0);
}
