// SPDX-License-Identifier: Apache-2.0
// What a record of a layer is about, in 55 bits: a block of a submap or a half of one, the pose of a submap, or what
// the writer says of itself. Of everything that has the same key the highest version stands.
//
//   bit 53..54 kind   41..52 submap   2..40 block key (M >> 9)   0..1 part
#pragma once

#include <cstdint>

#include "mapper/morton.hpp"
#include "net/block_part.hpp"

namespace g3d::net {

using RecordKey = std::uint64_t;
inline constexpr int kRecordKeyBits = 55;
inline constexpr std::uint32_t kMaxSubmaps = 1U << 12;

enum class RecordKind : std::uint8_t {
  block,
  submap_pose,
  status,  ///< place, goal, battery and the like of the writer
};
inline constexpr int kRecordKinds = 3;

[[nodiscard]] constexpr RecordKey block_record(std::uint32_t submap, mapper::BlockKey block, Part part) {
  return (static_cast<RecordKey>(submap) << 41) | (block << 2) | static_cast<RecordKey>(part);
}
[[nodiscard]] constexpr RecordKey pose_record(std::uint32_t submap) {
  return (RecordKey{1} << 53) | (static_cast<RecordKey>(submap) << 41);
}
/// `number`: of the things that a robot says of itself.
[[nodiscard]] constexpr RecordKey status_record(std::uint32_t number) {
  return (RecordKey{2} << 53) | (static_cast<RecordKey>(number) << 2);
}

[[nodiscard]] constexpr RecordKind kind_of(RecordKey key) { return static_cast<RecordKind>(key >> 53); }
[[nodiscard]] constexpr std::uint32_t submap_of_key(RecordKey key) {
  return static_cast<std::uint32_t>(key >> 41) & (kMaxSubmaps - 1);
}
[[nodiscard]] constexpr mapper::BlockKey block_key_of(RecordKey key) { return (key >> 2) & ((1ULL << 39) - 1); }
[[nodiscard]] constexpr Part part_of(RecordKey key) { return static_cast<Part>(key & 3U); }
/// The same block as a part of it.
[[nodiscard]] constexpr RecordKey with_part(RecordKey key, Part part) {
  return (key & ~RecordKey{3}) | static_cast<RecordKey>(part);
}
[[nodiscard]] constexpr bool is_record_key(RecordKey key) {
  return (key >> 53) < static_cast<RecordKey>(kRecordKinds) && (key & 3U) < static_cast<RecordKey>(kParts);
}

}  // namespace g3d::net
