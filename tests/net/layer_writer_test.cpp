// SPDX-License-Identifier: Apache-2.0
#include "net/layer_writer.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "tests/support/gossip_fleet.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using tests::GossipFleet;

namespace {

tests::FleetOptions lone_writer() {
  tests::FleetOptions options;
  options.robots = 1;
  options.store = {4, 1U << 13, std::size_t{8} << 20};
  return options;
}

void note_whole_map(net::LayerWriter& writer, const mapper::VoxelMap& map) {
  for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) writer.note_changed(std::array{slot});
}

}  // namespace

TEST_CASE("blocks in which robots drive go first, then edges of what is known, then the rest", "[net]") {
  const mapper::Grid grid{0.05F};
  const net::GroundBand band{-0.1F, 0.7F};
  mapper::BlockValues known{};
  known.fill(3);
  mapper::BlockValues edge = known;
  edge[17] = mapper::kUnknownLevel;
  const auto key_at = [&](float z_m) { return mapper::block_of(grid.to_index(1.0F, 1.0F, z_m)); };
  CHECK(net::lane_of(key_at(0.3F), known, grid, band) == net::Lane::ground);
  CHECK(net::lane_of(key_at(0.3F), edge, grid, band) == net::Lane::ground);
  CHECK(net::lane_of(key_at(-0.05F), known, grid, band) == net::Lane::ground);
  CHECK(net::lane_of(key_at(2.0F), edge, grid, band) == net::Lane::frontier);
  CHECK(net::lane_of(key_at(2.0F), known, grid, band) == net::Lane::rest);
  CHECK(net::lane_of(key_at(-1.0F), known, grid, band) == net::Lane::rest);
}

TEST_CASE("what is published once and has not changed costs nothing", "[net]") {
  const auto room = tests::furnished_room(0.1F);
  GossipFleet fleet(lone_writer());
  net::LayerWriter writer(*room, fleet.gossip(0), fleet.store(0));
  note_whole_map(writer, *room);
  const std::size_t bytes = writer.publish_round(1000000, fleet.now_ns());
  CHECK(bytes == writer.counts().published_bytes);
  CHECK(bytes == fleet.store(0).payload_bytes());
  CHECK(writer.counts().published_blocks == room->sorted_keys().size());
  const net::Version version = fleet.gossip(0).version();
  note_whole_map(writer, *room);
  CHECK(writer.publish_round(1000000, fleet.now_ns()) == 0);
  CHECK(writer.counts().unchanged_blocks == writer.counts().published_blocks);
  CHECK(fleet.gossip(0).version() == version);
  CHECK(writer.publish_round(1000000, fleet.now_ns()) == 0);
}

TEST_CASE("a round ends when enough is published, ground first, and the rest comes in later ones", "[net]") {
  const auto room = tests::furnished_room(0.1F);
  GossipFleet fleet(lone_writer());
  net::LayerWriter writer(*room, fleet.gossip(0), fleet.store(0));
  note_whole_map(writer, *room);
  std::size_t rounds = 0;
  std::uint64_t ground_before_others = 0;
  bool others_have_come = false;
  for (net::Version before = 0;; ++rounds) {
    const std::size_t bytes = writer.publish_round(300, fleet.now_ns());
    if (bytes == 0) break;
    CHECK(bytes < 300 + 2 * net::kMostPayload_bytes);
    net::Version ground = 0;
    fleet.store(0).for_each(0, [&](const net::StoredRecord& record) {
      if (record.version <= before) return;
      if (record.lane == net::Lane::ground) ++ground;
    });
    if (ground > 0 && others_have_come) FAIL("ground after others");
    others_have_come = ground < fleet.gossip(0).version() - before;
    ground_before_others += ground;
    before = fleet.gossip(0).version();
  }
  CHECK(rounds > 3);
  CHECK(ground_before_others > 10);
  CHECK(writer.counts().published_blocks == room->sorted_keys().size());
}

TEST_CASE("what finds no room in the store is tried again", "[net]") {
  const auto room = tests::furnished_room(0.1F);
  tests::FleetOptions options = lone_writer();
  options.store.records = 20;
  GossipFleet fleet(options);
  net::LayerWriter writer(*room, fleet.gossip(0), fleet.store(0));
  note_whole_map(writer, *room);
  (void)writer.publish_round(1000000, fleet.now_ns());
  CHECK(writer.counts().published_blocks == 20);
  const std::uint64_t refused = writer.counts().refused_blocks;
  CHECK(refused == room->sorted_keys().size() - 20);
  (void)writer.publish_round(1000000, fleet.now_ns());
  CHECK(writer.counts().refused_blocks == 2 * refused);
}

TEST_CASE("what is withdrawn becomes unknown for others, and comes back when it changes", "[net]") {
  const auto room = tests::furnished_room(0.1F);
  GossipFleet fleet(lone_writer());
  net::LayerWriter writer(*room, fleet.gossip(0), fleet.store(0));
  note_whole_map(writer, *room);
  (void)writer.publish_round(1000000, fleet.now_ns());
  const std::size_t all = fleet.store(0).payload_bytes();
  const std::uint32_t kept = 3;
  writer.withdraw_unless([&](std::uint32_t slot) { return slot == kept; });
  // However few at a time.
  for (int round = 0; round < 400; ++round) (void)writer.publish_round(10, fleet.now_ns());
  CHECK(fleet.store(0).payload_bytes() < all / 3);
  const auto size_of = [&](std::uint32_t slot) {
    const auto record = fleet.store(0).find_record(fleet.gossip(0).own_layer(),
                                                   net::block_record(0, room->header(slot).key, net::Part::whole));
    return record ? record->bytes : 0;
  };
  CHECK(size_of(kept) > size_of(4));
  writer.note_changed(std::array{4U});
  (void)writer.publish_round(1000000, fleet.now_ns());
  CHECK(size_of(4) > 8);
  writer.withdraw_unless([&](std::uint32_t slot) { return slot == kept || slot == 4; });
  CHECK(writer.publish_round(1000000, fleet.now_ns()) == 0);
}
