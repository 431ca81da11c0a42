// SPDX-License-Identifier: Apache-2.0
// Blocks as robots send them: those that changed while a map grew, as they were then. Mid-update, so noisier than what
// a finished map holds.
#pragma once

#include <string>
#include <vector>

#include "mapper/voxel_map.hpp"
#include "tests/support/workload.hpp"

namespace g3d::test {

/// Maps the frames and takes the changed blocks after every `frames_per_update` and the last, about `per_update` of
/// them at random.
[[nodiscard]] std::vector<mapper::BlockValues> changed_blocks(const Workload& work, float resolution_m,
                                                              std::size_t frames_per_update, std::uint32_t per_update);
/// Of two `map.g3d`: blocks of the later that are not so in the earlier. Empty if one cannot be read.
[[nodiscard]] std::vector<mapper::BlockValues> changed_blocks(const std::string& earlier, const std::string& later);
/// All blocks of a `map.g3d`. Empty if it cannot be read.
[[nodiscard]] std::vector<mapper::BlockValues> all_blocks(const std::string& path);

}  // namespace g3d::test
