// SPDX-License-Identifier: Apache-2.0
#include "tests/support/map_agreement.hpp"

#include <cstdlib>

namespace g3d::tests {

Agreement agreement(const mapper::VoxelMap& of, const mapper::VoxelMap& with) {
  Agreement result;
  mapper::BlockValues values;
  for (const mapper::BlockKey key : of.sorted_keys()) {
    of.read_stored_block(key, values);
    const mapper::VoxelIndex origin = mapper::block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (mapper::state_of(values[i]) != mapper::State::occupied) continue;
      ++result.occupied;
      const mapper::VoxelIndex p = mapper::decode(i);
      int nearest = 4;  // faces away
      for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
          for (int x = -1; x <= 1; ++x) {
            const int faces = std::abs(x) + std::abs(y) + std::abs(z);
            if (faces >= nearest) continue;
            const mapper::VoxelIndex v{origin.x + p.x + x, origin.y + p.y + y, origin.z + p.z + z};
            if (mapper::state_of(with.at(v)) == mapper::State::occupied) nearest = faces;
          }
        }
      }
      result.same += nearest == 0 ? 1 : 0;
      result.face += nearest <= 1 ? 1 : 0;
      result.around += nearest <= 3 ? 1 : 0;
    }
  }
  return result;
}

}  // namespace g3d::tests
