// SPDX-License-Identifier: Apache-2.0
#include "net/placement.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;

TEST_CASE("a placement travels in a few bytes and comes back as it was", "[net]") {
  const hal::Pose pose = hal::from_xyz_rpy(1.25, -3.5, 0.01, 0.1, 0.2, -2.0);
  const net::LayerId writer{7, 2};
  const auto said = net::Placement::as_said(pose, writer);
  const net::PlacementPayload plain(said, pose, 0.05F);
  CHECK(plain.bytes().size() == net::kPosePayload_bytes);
  const auto read = net::read_placement(plain.bytes(), writer);
  REQUIRE(read);
  CHECK(read->depth == 0);
  CHECK(read->root == writer);
  CHECK(read->T_world_map.translation_m == pose.translation_m);

  const net::Placement fitted{pose, {3, 9}, 2};
  const net::PlacementPayload more(fitted, pose, 0.05F);
  CHECK(more.bytes().size() == net::kPlacementPayload_bytes);
  CHECK(more.bytes().size() <= 80);
  const auto again = net::read_placement(more.bytes(), writer);
  REQUIRE(again);
  CHECK(again->root == net::LayerId{3, 9});
  CHECK(again->depth == 2);
  CHECK(again->T_world_map.rotation_xyzw == pose.rotation_xyzw);
  // Who wants the pose alone reads both.
  const auto alone = net::read_pose_payload(more.bytes());
  REQUIRE(alone);
  CHECK(alone->T_world_submap.translation_m == pose.translation_m);
  CHECK(alone->resolution_m == 0.05F);
}

TEST_CASE("what is no placement is refused", "[net]") {
  const net::Placement fitted{{}, {3, 9}, 2};
  const net::PlacementPayload payload(fitted, {}, 0.05F);
  std::vector<std::uint8_t> bytes(payload.bytes().begin(), payload.bytes().end());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const bool is_pose = size == net::kPosePayload_bytes;
    CHECK(net::read_placement(std::span(bytes).first(size), {1, 1}).has_value() == is_pose);
  }
  bytes.back() = 0;  // fitted, at depth zero
  CHECK_FALSE(net::read_placement(bytes, {1, 1}));
  bytes.back() = 1;
  bytes[7] = 0x7F;
  bytes[6] = 0xF0;  // infinite
  CHECK_FALSE(net::read_placement(bytes, {1, 1}));
}

TEST_CASE("a layer stands where the pose of its submap 0 says", "[net]") {
  net::LayerStore store({2, 64, 1U << 16, 16});
  const net::LayerIndex layer = store.find_or_add({5, 1});
  CHECK_FALSE(net::placement_of(store, layer));
  CHECK_FALSE(net::resolution_of(store, layer));
  const hal::Pose pose = hal::from_xyz_rpy(1, 2, 3, 0, 0, 1);
  const net::PlacementPayload payload({pose, {2, 4}, 1}, pose, 0.05F);
  REQUIRE(store.put(layer, net::pose_record(0), 1, net::Lane::ground, payload.bytes()) == net::LayerStore::Put::stored);
  const auto placed = net::placement_of(store, layer);
  REQUIRE(placed);
  CHECK(placed->root == net::LayerId{2, 4});
  CHECK(placed->depth == 1);
  CHECK(net::resolution_of(store, layer) == 0.05F);
}
