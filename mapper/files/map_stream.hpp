// SPDX-License-Identifier: Apache-2.0
// A map <-> the bytes of `map.g3d` (map_header.hpp), wherever these come from and go to. Chunks of up to 4096 blocks in
// ascending order of key, each compressed and with its own CRC, then an index and a total CRC.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hal/result.hpp"
#include "mapper/block_source.hpp"
#include "mapper/files/block_codec.hpp"
#include "mapper/files/map_header.hpp"

namespace g3d::mapper {

struct SaveReport {
  std::uint64_t file_bytes = 0;
  MapCounts counts;
};

struct LoadOptions {
  std::optional<MapCapacity> capacity;                     ///< none: exactly what the file needs
  std::size_t memory_limit_bytes = std::size_t{64} << 30;  ///< a file that claims to need more is refused
};

struct LoadedMap {
  std::unique_ptr<VoxelMap> map;
  MapInfo info;
};

/// Bytes go to `sink` in order, up to a chunk at a time. Thread: the map must not be written meanwhile.
using ByteSink = std::function<hal::Result<void>(ByteSpan)>;
[[nodiscard]] hal::Result<SaveReport> encode_map(const VoxelMap& map, const MapFileMeta& meta, const ByteSink& sink,
                                                 int zstd_level = kDefaultZstdLevel);
/// A map that may lie partly elsewhere: a chunk of it at a time is in memory. Errors: those of the source as well.
[[nodiscard]] hal::Result<SaveReport> encode_map(const BlockSource& source, const MapFileMeta& meta,
                                                 const ByteSink& sink, int zstd_level = kDefaultZstdLevel);
/// `name` stands for the file in error texts. Hostile bytes give an error; a map is returned only if everything is
/// valid.
[[nodiscard]] hal::Result<LoadedMap> decode_map(ByteSpan bytes, const std::string& name,
                                                const LoadOptions& options = {});

}  // namespace g3d::mapper
