// SPDX-License-Identifier: Apache-2.0
// `map.g3d`, the native map file. It is written to a temporary file, synced and renamed: after a crash at any moment
// the name holds the old map or the new one, whole. What is loaded is bit-identical to what was saved.
#pragma once

#include <string>

#include "mapper/files/map_stream.hpp"

namespace g3d::mapper {

/// Thread: the map must not be written meanwhile. Errors: those of the file system, texts name file and remedy.
[[nodiscard]] hal::Result<SaveReport> save_map(const VoxelMap& map, const MapFileMeta& meta, const std::string& path,
                                               int zstd_level = kDefaultZstdLevel);
[[nodiscard]] hal::Result<SaveReport> save_map(const BlockSource& source, const MapFileMeta& meta,
                                               const std::string& path, int zstd_level = kDefaultZstdLevel);
[[nodiscard]] hal::Result<LoadedMap> load_map(const std::string& path, const LoadOptions& options = {});
/// Reads the header alone, in constant time.
[[nodiscard]] hal::Result<MapInfo> read_map_info(const std::string& path);

}  // namespace g3d::mapper
