// SPDX-License-Identifier: Apache-2.0
// A block whose coding is longer than a datagram travels as two halves of 256 voxels each (M & 511 below 256, and the
// rest), each told without the other. What is newer counts, voxel by voxel.
#pragma once

#include <cstdint>

namespace g3d::net {

enum class Part : std::uint8_t { whole, low_half, high_half };
inline constexpr int kParts = 3;

}  // namespace g3d::net
