// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/map_header.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cassert>
#include <cmath>

#include "mapper/files/block_codec.hpp"

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

// Like PNG's: a byte above 127, a name, and line ends that a text transfer would spoil.
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'G', '3', 'D', '\r', '\n', 0x1A, '\n'};
constexpr std::array<std::uint8_t, 8> kEndMagic{'G', '3', 'D', ' ', 'e', 'n', 'd', '\n'};
constexpr std::array<std::uint8_t, 4> kChunkMagic{'C', 'H', 'N', 'K'};
constexpr std::array<std::uint8_t, 4> kIndexMagic{'I', 'N', 'D', 'X'};
constexpr BlockKey kKeyEnd = BlockKey{1} << (3 * kAxisBits - kBlockShift);
constexpr float kMinResolution_m = 0.0005F;
constexpr float kMaxResolution_m = 100.0F;
constexpr const char* kRemedy = "the file is damaged, take another copy or map again";

Error damaged(Reason reason, const std::string& name, std::size_t offset, const std::string& what) {
  return {reason, fmt::format("{}: byte {}: {}; {}", name, offset, what, kRemedy)};
}

}  // namespace

std::uint32_t crc32_of(ByteSpan bytes, std::uint32_t start) {
  return static_cast<std::uint32_t>(crc32_z(start, bytes.data(), bytes.size()));
}

Bytes encode_header(const MapInfo& info) {
  Bytes out;
  put(out, kMagic);
  put(out, info.version);
  put(out, static_cast<std::uint32_t>(kMapHeaderBytes));
  put(out, info.grid.resolution_m);
  put(out, info.meta.steps.hit);
  put(out, info.meta.steps.miss);
  put(out, std::uint16_t{0});
  put(out, info.meta.layer_id);
  put(out, info.meta.T_world_map.translation_m);
  put(out, info.meta.T_world_map.rotation_xyzw);
  for (const std::uint64_t count :
       {info.counts.occupied, info.counts.free, info.counts.coloured, info.counts.blocks, info.counts.uniform_blocks}) {
    put(out, count);
  }
  for (const std::uint32_t count : {info.dense_blocks, info.colour_bricks, info.chunks, 0U}) put(out, count);
  put(out, crc32_of(out));
  assert(out.size() == kMapHeaderBytes);
  return out;
}

hal::Result<MapInfo> decode_header(ByteSpan bytes, const std::string& name) {
  ByteReader in(bytes);
  std::array<std::uint8_t, 8> magic;
  if (!in.take(magic) || magic != kMagic) {
    return Error{Reason::malformed,
                 fmt::format("{}: byte 0: not a g3d map; give a map.g3d written by this program", name)};
  }
  MapInfo info;
  std::uint32_t header_bytes = 0;
  std::uint32_t crc = 0;
  std::uint16_t zero = 0;
  std::uint32_t zero_too = 0;
  if (!in.take(info.version)) return damaged(Reason::truncated, name, bytes.size(), "the header is cut off");
  if (info.version != 1) {
    return Error{Reason::unsupported,
                 fmt::format("{}: byte 8: version {} is unknown here; use a newer g3dmap", name, info.version)};
  }
  const bool complete = in.take(header_bytes) && in.take(info.grid.resolution_m) && in.take(info.meta.steps.hit) &&
                        in.take(info.meta.steps.miss) && in.take(zero) && in.take(info.meta.layer_id) &&
                        in.take(info.meta.T_world_map.translation_m) && in.take(info.meta.T_world_map.rotation_xyzw) &&
                        in.take(info.counts.occupied) && in.take(info.counts.free) && in.take(info.counts.coloured) &&
                        in.take(info.counts.blocks) && in.take(info.counts.uniform_blocks) &&
                        in.take(info.dense_blocks) && in.take(info.colour_bricks) && in.take(info.chunks) &&
                        in.take(zero_too) && in.take(crc);
  if (!complete) return damaged(Reason::truncated, name, bytes.size(), "the header is cut off");
  if (crc != crc32_of(bytes.first(kMapHeaderBytes - 4)))
    return damaged(Reason::bad_checksum, name, 0, "the header's CRC differs");
  if (header_bytes != kMapHeaderBytes) return damaged(Reason::malformed, name, 12, "the header's size is wrong");
  if (!(info.grid.resolution_m >= kMinResolution_m && info.grid.resolution_m <= kMaxResolution_m)) {
    return damaged(Reason::out_of_range, name, 16, fmt::format("resolution {} m", info.grid.resolution_m));
  }
  const UpdateSteps steps = info.meta.steps;
  if (steps.hit < 1 || steps.hit > 16 || steps.miss < 1 || steps.miss > 16) {
    return damaged(Reason::out_of_range, name, 20, fmt::format("steps +{} -{}", steps.hit, steps.miss));
  }
  if (!hal::is_valid(info.meta.T_world_map)) return damaged(Reason::out_of_range, name, 32, "the pose is not a pose");
  const MapCounts& c = info.counts;
  const bool possible = c.blocks <= std::uint64_t{info.chunks} * kMaxGroupBlocks && c.uniform_blocks <= c.blocks &&
                        c.blocks - c.uniform_blocks == info.dense_blocks &&
                        info.colour_bricks <= std::uint64_t{info.dense_blocks} * kBricksPerBlock &&
                        c.occupied <= c.blocks * kBlockVoxels && c.free <= c.blocks * kBlockVoxels - c.occupied &&
                        c.coloured <= c.occupied && zero == 0 && zero_too == 0;
  if (!possible) return damaged(Reason::out_of_range, name, 88, "the counts contradict each other");
  return info;
}

Bytes encode_chunk_header(const ChunkEntry& entry, ByteSpan payload, std::uint32_t& crc) {
  Bytes out;
  put(out, kChunkMagic);
  put(out, entry.blocks);
  put(out, entry.first_key);
  put(out, entry.last_key);
  put(out, static_cast<std::uint32_t>(payload.size()));
  crc = crc32_of(payload, crc32_of(out));
  put(out, crc);
  assert(out.size() == kChunkHeaderBytes);
  return out;
}

hal::Result<ChunkView> decode_chunk_header(ByteSpan file, std::size_t offset, const std::string& name) {
  if (offset > file.size()) return damaged(Reason::truncated, name, file.size(), "a chunk lies behind the end");
  ByteReader in(file.subspan(offset));
  ChunkView chunk;
  chunk.entry.offset = offset;
  std::array<std::uint8_t, 4> magic;
  std::uint32_t payload_bytes = 0;
  if (!in.take(magic) || !in.take(chunk.entry.blocks) || !in.take(chunk.entry.first_key) ||
      !in.take(chunk.entry.last_key) || !in.take(payload_bytes) || !in.take(chunk.crc)) {
    return damaged(Reason::truncated, name, offset, "a chunk is cut off");
  }
  if (magic != kChunkMagic) return damaged(Reason::malformed, name, offset, "no chunk where one must be");
  if (!in.take_bytes(payload_bytes, chunk.payload))
    return damaged(Reason::truncated, name, offset, "a chunk is cut off");
  if (chunk.crc != crc32_of(chunk.payload, crc32_of(file.subspan(offset, kChunkHeaderBytes - 4)))) {
    return damaged(Reason::bad_checksum, name, offset, "a chunk's CRC differs");
  }
  const ChunkEntry& e = chunk.entry;
  if (e.blocks == 0 || e.blocks > kMaxGroupBlocks || e.first_key > e.last_key || e.last_key >= kKeyEnd) {
    return damaged(Reason::out_of_range, name, offset,
                   fmt::format("a chunk claims {} blocks, keys {} to {}", e.blocks, e.first_key, e.last_key));
  }
  chunk.end_offset = offset + in.offset();
  return chunk;
}

Bytes encode_index(const std::vector<ChunkEntry>& chunks, std::uint64_t offset, std::uint32_t crc_so_far) {
  Bytes out;
  put(out, kIndexMagic);
  put(out, static_cast<std::uint32_t>(chunks.size()));
  for (const ChunkEntry& entry : chunks) {
    put(out, entry.offset);
    put(out, entry.first_key);
    put(out, entry.last_key);
    put(out, entry.blocks);
  }
  const std::uint32_t crc = crc32_of(out);
  put(out, crc);
  Bytes crc_bytes;
  put(crc_bytes, crc);
  put(out, offset);
  put(out, offset + out.size() - 8 + kMapEndBytes);
  put(out, crc32_of(crc_bytes, crc_so_far));
  put(out, kEndMagic);
  return out;
}

hal::Result<void> check_index(ByteSpan file, std::size_t offset, const std::vector<ChunkEntry>& chunks,
                              std::uint32_t crc_so_far, const std::string& name) {
  const Bytes expected = encode_index(chunks, offset, crc_so_far);
  const ByteSpan found = file.subspan(offset);
  if (found.size() < expected.size()) return damaged(Reason::truncated, name, file.size(), "the index is cut off");
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (found[i] != expected[i])
      return damaged(Reason::bad_checksum, name, offset + i, "the index does not match the chunks");
  }
  if (found.size() > expected.size())
    return damaged(Reason::malformed, name, offset + expected.size(), "bytes follow the end");
  return {};
}

}  // namespace g3d::mapper
