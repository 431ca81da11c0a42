// SPDX-License-Identifier: Apache-2.0
// T_world_submap as the payload of a record: x, y, z in metres and a unit quaternion x, y, z, w, each a little-endian
// binary64, and the edge of the submap's voxels in metres, a binary32. Exact, so that all robots resample alike, and
// nobody takes the blocks of another grid for those of his own.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "hal/geometry.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

inline constexpr std::size_t kPosePayload_bytes = 7 * sizeof(double) + sizeof(float);
using PosePayload = std::array<std::uint8_t, kPosePayload_bytes>;

[[nodiscard]] inline PosePayload pose_payload(const hal::Pose& pose, float resolution_m) {
  PosePayload bytes;
  std::memcpy(bytes.data(), pose.translation_m.data(), 3 * sizeof(double));
  std::memcpy(bytes.data() + 3 * sizeof(double), pose.rotation_xyzw.data(), 4 * sizeof(double));
  std::memcpy(bytes.data() + 7 * sizeof(double), &resolution_m, sizeof resolution_m);
  return bytes;
}
/// More than a pose may follow: see placement.hpp.
inline constexpr std::size_t kPoseTail_bytes = 13;
struct PlacedSubmap {
  hal::Pose T_world_submap;
  float resolution_m = 0.0F;
};
/// None if the bytes are no pose.
[[nodiscard]] inline std::optional<PlacedSubmap> read_pose_payload(mapper::ByteSpan bytes) {
  if (bytes.size() != kPosePayload_bytes && bytes.size() != kPosePayload_bytes + kPoseTail_bytes) return std::nullopt;
  PlacedSubmap read;
  std::memcpy(read.T_world_submap.translation_m.data(), bytes.data(), 3 * sizeof(double));
  std::memcpy(read.T_world_submap.rotation_xyzw.data(), bytes.data() + 3 * sizeof(double), 4 * sizeof(double));
  std::memcpy(&read.resolution_m, bytes.data() + 7 * sizeof(double), sizeof read.resolution_m);
  const bool is_size = std::isfinite(read.resolution_m) && read.resolution_m > 0.0F;
  return is_size && hal::is_valid(read.T_world_submap) ? std::optional(read) : std::nullopt;
}

}  // namespace g3d::net
