// SPDX-License-Identifier: Apache-2.0
// OctoMap files (octomap_format.hpp) of any program as a map: OcTree and ColorOcTree, `.ot` and `.bt`. Leaves above
// voxel size become uniform blocks or parts of blocks. The whole file is checked and measured before a map is made, so
// that a hostile one (huge leaves, endless depth, lying sizes) costs nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

struct OctomapOptions {
  std::size_t memory_limit_bytes = std::size_t{16} << 30;  ///< a tree that would need more is refused
};

struct OctomapContents {
  std::unique_ptr<VoxelMap> map;  ///< with exactly the room that the tree needs
  std::string tree_type;          ///< "OcTree" or "ColorOcTree"
  std::uint64_t nodes = 0;
  std::uint64_t occupied_leaves = 0;
  std::uint64_t free_leaves = 0;
};

/// `name` stands for the file in error texts. Errors: malformed, truncated, unsupported, out_of_range, no_capacity.
[[nodiscard]] hal::Result<OctomapContents> decode_octomap(ByteSpan bytes, const std::string& name,
                                                          const OctomapOptions& options = {});
[[nodiscard]] hal::Result<OctomapContents> read_octomap(const std::string& path, const OctomapOptions& options = {});

}  // namespace g3d::mapper
