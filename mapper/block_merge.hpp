// SPDX-License-Identifier: Apache-2.0
// Two states of one block that were kept apart for a while become one: level = clamp(16 + sum(O - 16)) over those that
// know the voxel, colour from the one that is surer of it (on a tie the older one), the same rule by which maps merge.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "mapper/files/block_codec.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// Codes with kHasColourBit, both ways.
[[nodiscard]] constexpr Rgbo merged_value(Rgbo older, Rgbo newer) {
  if (state_of(older) == State::unknown) return newer;
  if (state_of(newer) == State::unknown) return older;
  const int level = std::clamp<int>(level_of(older) + level_of(newer) - kUnknownLevel, 0, kMaxLevel);
  if (level <= kUnknownLevel) return static_cast<Rgbo>(level);
  const bool older_coloured = (older & kHasColourBit) != 0;
  const bool newer_coloured = (newer & kHasColourBit) != 0;
  const bool take_newer = newer_coloured && (!older_coloured || level_of(newer) > level_of(older));
  const Rgbo colour = (take_newer ? newer : older) & (0xFFFFFF00U | kHasColourBit);
  return colour | static_cast<Rgbo>(level);
}

void merge_into(BlockValues& newer, const BlockValues& older);

/// Two lists of blocks in ascending order of key become one. `out` has room for all of both and overlaps neither.
/// Returns how many blocks it holds.
std::size_t merge_lists(std::span<const StoredBlock> older, std::span<const StoredBlock> newer,
                        std::span<StoredBlock> out);

}  // namespace g3d::mapper
