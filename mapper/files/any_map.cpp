// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/any_map.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "mapper/files/map_file.hpp"
#include "mapper/files/octomap_read.hpp"

namespace g3d::mapper {

hal::Result<AnyMap> read_any_map(const std::string& path) {
  const std::string ending = std::filesystem::path(path).extension().string();
  AnyMap any;
  if (ending == ".g3d") {
    hal::Result<LoadedMap> loaded = load_map(path);
    if (!loaded) return loaded.error();
    any.map = std::move(loaded.value().map);
    any.meta = loaded.value().info.meta;
    any.format = fmt::format("g3d {}", loaded.value().info.version);
  } else if (ending == ".ot" || ending == ".bt") {
    hal::Result<OctomapContents> read = read_octomap(path);
    if (!read) return read.error();
    any.map = std::move(read.value().map);
    any.format = "OctoMap " + read.value().tree_type;
  } else {
    return hal::Error{
        hal::Reason::unsupported,
        fmt::format("{}: no kind of map is known by the ending '{}'; give a .g3d, .ot or .bt file", path, ending)};
  }
  std::error_code ignored;
  any.file_bytes = std::filesystem::file_size(path, ignored);
  return any;
}

}  // namespace g3d::mapper
