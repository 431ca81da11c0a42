// SPDX-License-Identifier: Apache-2.0
// T_world_submap as the payload of a record: x, y, z in metres and a unit quaternion x, y, z, w, each a little-endian
// binary64. Exact, so that all robots resample alike.
#pragma once

#include <array>
#include <bit>
#include <cstring>

#include "hal/geometry.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::net {

inline constexpr std::size_t kPosePayload_bytes = 7 * sizeof(double);
using PosePayload = std::array<std::uint8_t, kPosePayload_bytes>;

[[nodiscard]] inline PosePayload pose_payload(const hal::Pose& pose) {
  PosePayload bytes;
  std::memcpy(bytes.data(), pose.translation_m.data(), 3 * sizeof(double));
  std::memcpy(bytes.data() + 3 * sizeof(double), pose.rotation_xyzw.data(), 4 * sizeof(double));
  return bytes;
}
/// More than a pose may follow: see placement.hpp.
inline constexpr std::size_t kPoseTail_bytes = 13;
/// False if the bytes are no pose; `pose` is then as before.
[[nodiscard]] inline bool read_pose_payload(mapper::ByteSpan bytes, hal::Pose& pose) {
  if (bytes.size() != kPosePayload_bytes && bytes.size() != kPosePayload_bytes + kPoseTail_bytes) return false;
  hal::Pose read;
  std::memcpy(read.translation_m.data(), bytes.data(), 3 * sizeof(double));
  std::memcpy(read.rotation_xyzw.data(), bytes.data() + 3 * sizeof(double), 4 * sizeof(double));
  if (!hal::is_valid(read)) return false;
  pose = read;
  return true;
}

}  // namespace g3d::net
