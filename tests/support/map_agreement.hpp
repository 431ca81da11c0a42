// SPDX-License-Identifier: Apache-2.0
// How much of what is occupied in one map is occupied within one voxel in another, both in one grid.
#pragma once

#include <cstdint>

#include "mapper/voxel_map.hpp"

namespace g3d::tests {

struct Agreement {
  std::uint64_t occupied = 0;
  std::uint64_t same = 0;    ///< the voxel itself
  std::uint64_t face = 0;    ///< or one of the six that share a face with it
  std::uint64_t around = 0;  ///< or one of the 26 around it
  [[nodiscard]] double by_face() const { return share(face); }
  [[nodiscard]] double beside() const { return share(around); }

 private:
  [[nodiscard]] double share(std::uint64_t count) const {
    return occupied > 0 ? static_cast<double>(count) / static_cast<double>(occupied) : 0.0;
  }
};

[[nodiscard]] Agreement agreement(const mapper::VoxelMap& of, const mapper::VoxelMap& with);

}  // namespace g3d::tests
