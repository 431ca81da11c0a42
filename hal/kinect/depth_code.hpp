// SPDX-License-Identifier: Apache-2.0
// Whether a compressed depth image of an .oni file ("16zT" and "16zP", run lengths and differences of PrimeSense's)
// decodes to exactly the pixels that it should. OpenNI2's decoder believes what it reads: it leaves its tables and its
// input where an image is damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace g3d::hal::kinect {

/// `has_table`: 16zT, values are places in a table that comes first.
[[nodiscard]] bool is_whole_depth_code(std::span<const std::uint8_t> code, bool has_table, std::size_t pixels);

}  // namespace g3d::hal::kinect
