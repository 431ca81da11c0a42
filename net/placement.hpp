// SPDX-License-Identifier: Apache-2.0
// Where a layer stands in the world, and how that is known: as it was said at the start, or by fitting its map to the
// maps of others. Layers that were fitted to each other have one root, the layer that stayed where it was said to be.
// `depth` counts the fits from there. A layer is fitted to lower roots, or to less depth under its own, and never the
// other way round: so nobody runs after anybody, and all come to rest.
//
//   payload   pose (pose_payload.hpp); if the depth is not zero: u64 robot, u32 incarnation of the root, u8 depth
#pragma once

#include <array>
#include <optional>
#include <span>

#include "net/layer_id.hpp"
#include "net/layer_store.hpp"
#include "net/pose_payload.hpp"

namespace g3d::net {

struct Placement {
  hal::Pose T_world_map;
  LayerId root;  ///< the layer itself at depth zero
  std::uint8_t depth = 0;

  [[nodiscard]] static Placement as_said(const hal::Pose& T_world_map, const LayerId& self) {
    return {T_world_map, self, 0};
  }
};

inline constexpr std::size_t kPlacementPayload_bytes = kPosePayload_bytes + kPoseTail_bytes;

class PlacementPayload {
 public:
  /// Of a submap that stands at `T_world_submap`, with voxels of that size, in a layer that is placed so.
  PlacementPayload(const Placement& placement, const hal::Pose& T_world_submap, float resolution_m);
  [[nodiscard]] mapper::ByteSpan bytes() const { return std::span(bytes_).first(size_); }

 private:
  std::array<std::uint8_t, kPlacementPayload_bytes> bytes_{};
  std::size_t size_ = kPosePayload_bytes;
};

/// `writer`: of the layer that it is from. None if the bytes are no placement.
[[nodiscard]] std::optional<Placement> read_placement(mapper::ByteSpan bytes, const LayerId& writer);
/// Of a layer, as the pose of its submap 0 says. None if that is not known.
[[nodiscard]] std::optional<Placement> placement_of(const LayerStore& store, LayerIndex layer);
/// Edge of its voxels, as the same record says.
[[nodiscard]] std::optional<float> resolution_of(const LayerStore& store, LayerIndex layer);

}  // namespace g3d::net
