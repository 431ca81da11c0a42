// SPDX-License-Identifier: Apache-2.0
// The text header of OctoMap's files: a first line that names the format, then `id`, `size`, `res` and `data`, with
// comment lines anywhere between.
#pragma once

#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"

namespace g3d::mapper {

struct OctomapHeader {
  bool is_binary = false;    ///< `.bt`
  bool is_coloured = false;  ///< ColorOcTree
  std::uint64_t nodes = 0;   ///< as claimed by `size`
  double resolution_m = 0;
  std::size_t data_offset = 0;
};

[[nodiscard]] hal::Result<OctomapHeader> decode_octomap_header(ByteSpan bytes, const std::string& name);

}  // namespace g3d::mapper
