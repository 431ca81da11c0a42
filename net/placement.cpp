// SPDX-License-Identifier: Apache-2.0
#include "net/placement.hpp"

#include <algorithm>
#include <cstring>

namespace g3d::net {

PlacementPayload::PlacementPayload(const Placement& placement, const hal::Pose& T_world_submap) {
  const PosePayload pose = pose_payload(T_world_submap);
  std::copy(pose.begin(), pose.end(), bytes_.begin());
  if (placement.depth == 0) return;
  std::uint8_t* at = bytes_.data() + kPosePayload_bytes;
  std::memcpy(at, &placement.root.robot, 8);
  std::memcpy(at + 8, &placement.root.incarnation, 4);
  at[12] = placement.depth;
  size_ = kPlacementPayload_bytes;
}

std::optional<Placement> read_placement(mapper::ByteSpan bytes, const LayerId& writer) {
  Placement placement = Placement::as_said({}, writer);
  if (!read_pose_payload(bytes, placement.T_world_map)) return std::nullopt;
  if (bytes.size() == kPosePayload_bytes) return placement;
  const std::uint8_t* at = bytes.data() + kPosePayload_bytes;
  std::memcpy(&placement.root.robot, at, 8);
  std::memcpy(&placement.root.incarnation, at + 8, 4);
  placement.depth = at[12];
  return placement.depth > 0 ? std::optional(placement) : std::nullopt;
}

std::optional<Placement> placement_of(const LayerStore& store, LayerIndex layer) {
  const std::optional<StoredRecord> first = store.find_record(layer, pose_record(0));
  if (!first) return std::nullopt;
  std::array<std::uint8_t, kPlacementPayload_bytes> bytes{};
  if (first->bytes > bytes.size()) return std::nullopt;
  store.read(*first, std::span(bytes).first(first->bytes));
  return read_placement(std::span(bytes).first(first->bytes), store.id(layer));
}

}  // namespace g3d::net
