// SPDX-License-Identifier: Apache-2.0
#include "net/placement.hpp"

#include <algorithm>
#include <cstring>

namespace g3d::net {

PlacementPayload::PlacementPayload(const Placement& placement, const hal::Pose& T_world_submap, float resolution_m) {
  const PosePayload pose = pose_payload(T_world_submap, resolution_m);
  std::copy(pose.begin(), pose.end(), bytes_.begin());
  if (placement.depth == 0) return;
  std::uint8_t* at = bytes_.data() + kPosePayload_bytes;
  std::memcpy(at, &placement.root.robot, 8);
  std::memcpy(at + 8, &placement.root.incarnation, 4);
  at[12] = placement.depth;
  size_ = kPlacementPayload_bytes;
}

std::optional<Placement> read_placement(mapper::ByteSpan bytes, const LayerId& writer) {
  const std::optional<PlacedSubmap> submap = read_pose_payload(bytes);
  if (!submap) return std::nullopt;
  Placement placement = Placement::as_said(submap->T_world_submap, writer);
  if (bytes.size() == kPosePayload_bytes) return placement;
  const std::uint8_t* at = bytes.data() + kPosePayload_bytes;
  std::memcpy(&placement.root.robot, at, 8);
  std::memcpy(&placement.root.incarnation, at + 8, 4);
  placement.depth = at[12];
  return placement.depth > 0 ? std::optional(placement) : std::nullopt;
}

namespace {

/// The bytes that say where submap 0 is; none if that is not known.
struct FirstPose {
  std::array<std::uint8_t, kPlacementPayload_bytes> bytes{};
  std::size_t size = 0;
  [[nodiscard]] mapper::ByteSpan span() const { return std::span(bytes).first(size); }
};
FirstPose first_pose(const LayerStore& store, LayerIndex layer) {
  FirstPose pose;
  const std::optional<StoredRecord> first = store.find_record(layer, pose_record(0));
  if (!first || first->bytes > pose.bytes.size()) return pose;
  pose.size = first->bytes;
  store.read(*first, std::span(pose.bytes).first(pose.size));
  return pose;
}

}  // namespace

std::optional<Placement> placement_of(const LayerStore& store, LayerIndex layer) {
  return read_placement(first_pose(store, layer).span(), store.id(layer));
}

std::optional<float> resolution_of(const LayerStore& store, LayerIndex layer) {
  const auto placed = read_pose_payload(first_pose(store, layer).span());
  return placed ? std::optional(placed->resolution_m) : std::nullopt;
}

}  // namespace g3d::net
