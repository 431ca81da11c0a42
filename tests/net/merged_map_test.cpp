// SPDX-License-Identifier: Apache-2.0
#include "net/merged_map.hpp"

#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <vector>

#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "net/layer_writer.hpp"
#include "tests/support/gossip_fleet.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kMergeSecond_ns = 1'000'000'000;

net::MergedOptions merged_options(const mapper::VoxelMap& like) {
  return {like.grid(), {1U << 13, 1U << 13, 1U << 14}, {1U << 12, 1U << 12, 1U << 13}, 8};
}

void note_all(net::LayerWriter& writer, const mapper::VoxelMap& map) {
  for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) writer.note_changed(std::array{slot});
}

tests::FleetOptions fleet_of(std::uint32_t robots) {
  tests::FleetOptions options;
  options.robots = robots;
  options.store = {8, 1U << 14, std::size_t{8} << 20, 1U << 12};
  options.radio.loss = 0.2;
  return options;
}

}  // namespace

TEST_CASE("a layer of voxels of another size is not taken for one of ours", "[net][merge]") {
  const auto ours = tests::random_map(4, 30, 0.1F);
  const auto theirs = tests::random_map(9, 30, 0.05F);
  GossipFleet fleet(fleet_of(2));
  net::LayerWriter our_writer(*ours, fleet.gossip(0), fleet.store(0));
  net::LayerWriter their_writer(*theirs, fleet.gossip(1), fleet.store(1));
  REQUIRE(our_writer.publish_pose({}, fleet.now_ns()));
  REQUIRE(their_writer.publish_pose({}, fleet.now_ns()));
  note_all(our_writer, *ours);
  note_all(their_writer, *theirs);
  for (int round = 0; round < 40; ++round) {
    (void)our_writer.publish_round(20000, fleet.now_ns());
    (void)their_writer.publish_round(20000, fleet.now_ns());
    fleet.run(kMergeSecond_ns / 10);
  }
  REQUIRE(fleet.run_until_equal(60 * kMergeSecond_ns));
  net::MergedMap merged(merged_options(*ours));
  merged.take_all(fleet.store(0));
  CHECK(merged.counts().other_grids == 1);
  CHECK(mapper::map_hash(merged.map()) == mapper::map_hash(*ours));
  net::MergedMap of_other(merged_options(*theirs));
  of_other.take_all(fleet.store(0));
  CHECK(mapper::map_hash(of_other.map()) == mapper::map_hash(*theirs));
}

TEST_CASE("robots whose maps stand anywhere in the world come to the map that merging them at once gives",
          "[net][merge][slow]") {
  const std::array<std::unique_ptr<mapper::VoxelMap>, 3> maps{
      tests::furnished_room(0.1F), tests::random_map(4, 60, 0.1F), tests::random_map(9, 60, 0.1F)};
  const std::array<hal::Pose, 3> poses{hal::Pose{}, hal::from_xyz_rpy(0.4, -0.2, 0.0, 0.0, 0.0, 0.0),
                                       hal::from_xyz_rpy(1.33, 0.77, 0.0, 0.0, 0.0, 0.6)};
  GossipFleet fleet(fleet_of(3));
  std::vector<std::unique_ptr<net::LayerWriter>> writers;
  std::vector<std::unique_ptr<net::MergedMap>> merged;
  for (std::uint32_t i = 0; i < 3; ++i) {
    writers.push_back(std::make_unique<net::LayerWriter>(*maps[i], fleet.gossip(i), fleet.store(i)));
    merged.push_back(std::make_unique<net::MergedMap>(merged_options(*maps[0])));
    REQUIRE(writers[i]->publish_pose(poses[i], fleet.now_ns()));
    note_all(*writers[i], *maps[i]);
  }
  // A few blocks at a time, merged as they come.
  for (int round = 0; round < 40; ++round) {
    for (std::uint32_t i = 0; i < 3; ++i) {
      (void)writers[i]->publish_round(2000, fleet.now_ns());
      merged[i]->update(fleet.store(i));
    }
    fleet.run(kMergeSecond_ns / 5);
  }
  for (std::uint32_t i = 0; i < 3; ++i) {
    while (writers[i]->publish_round(1000000, fleet.now_ns()) > 0) {
    }
  }
  REQUIRE(fleet.run_until_equal(30 * kMergeSecond_ns));
  std::vector<mapper::MergeSource> sources;
  for (std::size_t i = 0; i < 3; ++i) sources.push_back({maps[i].get(), poses[i], i});
  const auto at_once = mapper::merge_maps(sources);
  REQUIRE(at_once);
  for (std::uint32_t i = 0; i < 3; ++i) {
    INFO("robot " << i);
    merged[i]->update(fleet.store(i));
    CHECK(merged[i]->counts().bad_payloads == 0);
    CHECK(merged[i]->counts().refused_blocks == 0);
    CHECK(mapper::map_hash(merged[i]->map()) == mapper::map_hash(*at_once.value()));
  }
  CHECK(at_once.value()->counts().occupied > 1000);
}

TEST_CASE("a corrected pose moves a layer, and no block of it travels again", "[net][merge]") {
  const auto room = tests::furnished_room(0.1F);
  GossipFleet fleet(fleet_of(2));
  net::LayerWriter writer(*room, fleet.gossip(0), fleet.store(0));
  net::MergedMap merged(merged_options(*room));
  REQUIRE(writer.publish_pose({}, fleet.now_ns()));
  note_all(writer, *room);
  (void)writer.publish_round(1000000, fleet.now_ns());
  REQUIRE(fleet.run_until_equal(30 * kMergeSecond_ns));
  merged.update(fleet.store(1));
  CHECK(mapper::map_hash(merged.map()) == mapper::map_hash(*room));

  const std::uint64_t sent_before = fleet.sent_bytes();
  const hal::Pose corrected = hal::from_xyz_rpy(0.23, -0.4, 0.0, 0.0, 0.0, 0.1);
  REQUIRE(writer.publish_pose(corrected, fleet.now_ns()));
  REQUIRE(fleet.run_until_equal(10 * kMergeSecond_ns));
  CHECK(fleet.sent_bytes() - sent_before < 5000);
  merged.update(fleet.store(1));
  CHECK(merged.counts().moved_submaps == 1);
  const std::array<mapper::MergeSource, 1> source{mapper::MergeSource{room.get(), corrected, 0}};
  CHECK(mapper::map_hash(merged.map()) == mapper::map_hash(*mapper::merge_maps(source).value()));
}

TEST_CASE("what changes in a map changes in the merged map, and what is erased is unknown there", "[net][merge]") {
  auto map = tests::random_map(3, 40, 0.1F);
  GossipFleet fleet(fleet_of(2));
  net::LayerWriter writer(*map, fleet.gossip(0), fleet.store(0));
  net::MergedMap merged(merged_options(*map));
  REQUIRE(writer.publish_pose({}, fleet.now_ns()));
  tests::Random random(5);
  note_all(writer, *map);
  for (int round = 0; round < 20; ++round) {
    (void)writer.publish_round(1000000, fleet.now_ns());
    REQUIRE(fleet.run_until_equal(10 * kMergeSecond_ns));
    merged.update(fleet.store(1));
    REQUIRE(mapper::map_hash(merged.map()) == mapper::map_hash(*map));
    for (int change = 0; change < 5; ++change) {
      const std::vector<mapper::BlockKey> keys = map->sorted_keys();
      const mapper::BlockKey key = keys[random.below(static_cast<std::uint32_t>(keys.size()))];
      const std::uint32_t slot = map->find(key);
      if (random.below(4) == 0) {
        (void)map->erase_block(key);
      } else {
        mapper::BlockValues values{};
        (void)map->read_stored_block(key, values);
        for (int i = 0; i < 30; ++i) values[random.below(512)] = random.below(33);
        REQUIRE(map->write_block(key, values));
      }
      writer.note_changed(std::array{slot});
    }
  }
}

TEST_CASE("a layer that is refused leaves the merged map, and what others saw there stays", "[net][merge]") {
  const std::array<std::unique_ptr<mapper::VoxelMap>, 3> maps{
      tests::furnished_room(0.1F), tests::random_map(4, 60, 0.1F), tests::random_map(9, 60, 0.1F)};
  GossipFleet fleet(fleet_of(3));
  for (std::uint32_t i = 0; i < 3; ++i) {
    net::LayerWriter writer(*maps[i], fleet.gossip(i), fleet.store(i));
    REQUIRE(writer.publish_pose({}, fleet.now_ns()));
    note_all(writer, *maps[i]);
    (void)writer.publish_round(10000000, fleet.now_ns());
  }
  REQUIRE(fleet.run_until_equal(60 * kMergeSecond_ns));
  net::MergedMap merged(merged_options(*maps[0]));
  merged.update(fleet.store(0));
  REQUIRE(merged.submap_count() == 3);
  const std::string with_all = mapper::map_hash(merged.map());
  REQUIRE(fleet.store(0).refuse_robot(2));
  merged.update(fleet.store(0));
  CHECK(merged.submap_count() == 2);
  CHECK(merged.counts().dropped_submaps == 1);
  net::MergedMap anew(merged_options(*maps[0]));
  anew.take_all(fleet.store(0));
  CHECK(mapper::map_hash(merged.map()) == mapper::map_hash(anew.map()));
  CHECK(mapper::map_hash(merged.map()) != with_all);
  const std::vector<mapper::MergeSource> sources{{maps[0].get(), {}, 0}, {maps[2].get(), {}, 1}};
  CHECK(mapper::map_hash(merged.map()) == mapper::map_hash(*mapper::merge_maps(sources).value()));
}

TEST_CASE("a refused robot's layers are gone at once, never come back, and give their room back bit by bit", "[net]") {
  tests::Random random(3);
  net::LayerStore with({5, 2000, 100000}), without({5, 2000, 100000});
  const auto fill = [&](net::LayerStore& store, std::uint64_t robot) {
    for (net::Version version = 1; version <= 300; ++version) {
      const net::LayerIndex layer = store.find_or_add({robot, 1 + random.below(3)});
      if (layer == net::kNoLayer) continue;
      const auto lane = static_cast<net::Lane>(random.below(3));
      const net::RecordKey key = net::block_record(0, random.below(200), static_cast<net::Part>(random.below(3)));
      (void)store.put(layer, key, version, lane, mapper::Bytes(random.below(60)));
      (void)store.add_had(layer, lane, {0, version});
    }
  };
  random = tests::Random(3);
  fill(with, 7);
  random = tests::Random(3);
  fill(without, 7);
  fill(with, 8);  // two layers more find room
  std::size_t told = 0;
  with.take_changes([&](net::LayerIndex, net::RecordKey) { ++told; });
  REQUIRE(told > 200);
  const std::uint32_t before = with.record_count();
  REQUIRE(with.refuse_robot(8));
  CHECK(with.refuse_robot(8));
  CHECK(with.digest() == without.digest());
  CHECK(with.find({8, 1}) == net::kNoLayer);
  CHECK(with.find_or_add({8, 9}) == net::kNoLayer);
  std::set<net::LayerIndex> refused;
  with.take_changes([&](net::LayerIndex layer, net::RecordKey key) {
    REQUIRE(with.is_refused(layer));
    CHECK_FALSE(with.find_record(layer, key));
    refused.insert(layer);
  });
  REQUIRE(refused.size() == 2);
  for (const net::LayerIndex layer : refused) {
    CHECK(with.put(layer, net::pose_record(1), 9999, net::Lane::rest, mapper::Bytes{1}) ==
          net::LayerStore::Put::refused);
    CHECK_FALSE(with.add_had(layer, net::Lane::rest, {0, 9999}));
    CHECK(with.highest(layer) == 0);
    int visited = 0;
    with.for_each(layer, [&](const net::StoredRecord&) { ++visited; });
    CHECK(visited == 0);
  }
  int calls = 0;
  std::uint32_t left = with.record_count();
  REQUIRE(left == before);
  for (; with.drop_some(10); ++calls) {
    REQUIRE(left - with.record_count() == 10);
    left = with.record_count();
  }
  CHECK(calls >= 5);
  CHECK(with.record_count() == without.record_count());
  CHECK(with.payload_bytes() == without.payload_bytes());
  CHECK_FALSE(with.drop_some(1));
}
