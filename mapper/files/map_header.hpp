// SPDX-License-Identifier: Apache-2.0
// Header, chunk frame and index of `map.g3d`, version 1, little-endian. CRC32 as in zlib.
//
//   header   magic[8] u32 version, u32 header bytes, f32 resolution, u8 hit, u8 miss, u16 0, u64 layer, f64 pose[7],
//            u64 occupied, free, coloured, blocks, uniform blocks, u32 dense blocks, bricks, chunks, 0, u32 CRC
//   chunk    "CHNK" u32 blocks, u64 first key, u64 last key, u32 payload bytes, u32 CRC of all this and the payload;
//   payload index    "INDX" u32 chunks, per chunk (u64 offset, u64 first key, u64 last key, u32 blocks), u32 CRC end
//   u64 index offset, u64 file bytes, u32 CRC over all CRCs before, magic[8]
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

/// What a map file carries besides its voxels.
struct MapFileMeta {
  hal::Pose T_world_map;       ///< where this map stands among others
  UpdateSteps steps;           ///< with which it was made
  std::uint64_t layer_id = 0;  ///< who made it; breaks ties when maps are merged
};

struct MapInfo {
  std::uint32_t version = 1;
  Grid grid;
  MapFileMeta meta;
  MapCounts counts;
  std::uint32_t dense_blocks = 0;
  std::uint32_t colour_bricks = 0;
  std::uint32_t chunks = 0;
  std::uint64_t file_bytes = 0;
};

struct ChunkEntry {
  std::uint64_t offset = 0;  ///< of the chunk's "CHNK" in the file
  BlockKey first_key = 0;
  BlockKey last_key = 0;
  std::uint32_t blocks = 0;
  bool operator==(const ChunkEntry&) const = default;
};

inline constexpr std::size_t kMapHeaderBytes = 148;
inline constexpr std::size_t kChunkHeaderBytes = 32;
inline constexpr std::size_t kIndexEntryBytes = 28;
inline constexpr std::size_t kMapEndBytes = 28;

[[nodiscard]] std::uint32_t crc32_of(ByteSpan bytes, std::uint32_t start = 0);

[[nodiscard]] Bytes encode_header(const MapInfo& info);
/// Only the header is looked at; `name` goes into error texts. info.file_bytes is left 0.
[[nodiscard]] hal::Result<MapInfo> decode_header(ByteSpan bytes, const std::string& name);

/// The 32 bytes before a payload.
[[nodiscard]] Bytes encode_chunk_header(const ChunkEntry& entry, ByteSpan payload, std::uint32_t& crc);
struct ChunkView {
  ChunkEntry entry;
  ByteSpan payload;
  std::uint32_t crc = 0;
  std::size_t end_offset = 0;
};
/// The chunk at `offset`, CRC checked, keys in range and ascending; the payload is not decoded.
[[nodiscard]] hal::Result<ChunkView> decode_chunk_header(ByteSpan file, std::size_t offset, const std::string& name);

/// Index and end.
[[nodiscard]] Bytes encode_index(const std::vector<ChunkEntry>& chunks, std::uint64_t offset, std::uint32_t crc_so_far);
/// Compares what stands at `offset` to the file's end with what must stand there.
[[nodiscard]] hal::Result<void> check_index(ByteSpan file, std::size_t offset, const std::vector<ChunkEntry>& chunks,
                                            std::uint32_t crc_so_far, const std::string& name);

}  // namespace g3d::mapper
