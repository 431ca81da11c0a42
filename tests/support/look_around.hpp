// SPDX-License-Identifier: Apache-2.0
// Small maps to be aligned: what a robot sees that turns once on the spot, or drives a piece of a built-in way.
#pragma once

#include <memory>
#include <string>

#include "hal/geometry.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/workload.hpp"

namespace g3d::test {

/// One turn on the spot at a start of the world that `seed` chooses, 18 frames; map and poses in the world's frame.
[[nodiscard]] Workload look_around(const std::string& world, std::uint64_t seed);

/// A map of some frames, in a frame of its own: what stands at p in the world stands at T_map_world p there.
[[nodiscard]] std::unique_ptr<mapper::Mapper> map_in_own_frame(const Workload& work, std::size_t first,
                                                               std::size_t count, float resolution_m,
                                                               const hal::Pose& T_map_world);

}  // namespace g3d::test
