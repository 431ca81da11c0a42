// SPDX-License-Identifier: Apache-2.0
// What a robot drives by when others share their maps with it: its own map together with what they have seen. Own
// blocks are in it with the frame that changed them, others' whenever they come.
#pragma once

#include <cstdint>
#include <span>

#include "mapper/voxel_map.hpp"

namespace g3d::nav {

class SharedSight {
 public:
  virtual ~SharedSight() = default;
  /// Blocks of the robot's own map have changed. Returns the slots of map() that have changed by that, until the next
  /// call.
  virtual std::span<const std::uint32_t> on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) = 0;
  /// What the others have seen meanwhile, as much of it as should be taken at a time. Returns the same, empty if there
  /// is nothing new. For a robot in threads; in lockstep whoever merges says what has changed.
  virtual std::span<const std::uint32_t> take_news() { return {}; }
  [[nodiscard]] virtual const mapper::VoxelMap& map() const = 0;
};

}  // namespace g3d::nav
