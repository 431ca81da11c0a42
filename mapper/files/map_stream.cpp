// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/map_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

MapInfo describe(const VoxelMap& map, const MapFileMeta& meta, const std::vector<BlockKey>& keys) {
  MapInfo info;
  info.grid = map.grid();
  info.meta = meta;
  info.counts = map.counts();
  info.counts.blocks = keys.size();  // blocks without a known voxel are not saved
  for (const BlockKey key : keys) {
    const BlockHeader& header = map.header(map.find(key));
    if (header.plane == kNoSlot) continue;
    ++info.dense_blocks;
    for (const std::uint32_t brick : header.bricks) info.colour_bricks += brick == kNoSlot ? 0 : 1;
  }
  info.counts.uniform_blocks = keys.size() - info.dense_blocks;
  info.chunks = static_cast<std::uint32_t>((keys.size() + kMaxGroupBlocks - 1) / kMaxGroupBlocks);
  return info;
}

void chain_crc(std::uint32_t& chain, std::uint32_t crc) {
  Bytes bytes;
  put(bytes, crc);
  chain = crc32_of(bytes, chain);
}

std::uint32_t stored_crc(ByteSpan header) {
  std::uint32_t crc = 0;
  std::memcpy(&crc, header.data() + kMapHeaderBytes - 4, 4);
  return crc;
}

MapCapacity capacity_of(const MapInfo& info) {
  return {static_cast<std::uint32_t>(std::max<std::uint64_t>(info.counts.blocks, 1)), std::max(info.dense_blocks, 1U),
          std::max(info.colour_bricks, 1U)};
}

std::size_t memory_of(const MapInfo& info) {
  return info.counts.blocks * (sizeof(BlockHeader) + 16) + info.dense_blocks * sizeof(LevelPlane) +
         info.colour_bricks * sizeof(ColourBrick);
}

Error too_small(const std::string& name, const MapInfo& info) {
  return {Reason::no_capacity,
          fmt::format("{}: a map of {} blocks ({} dense) does not fit into the memory allowed; allow more", name,
                      info.counts.blocks, info.dense_blocks)};
}

hal::Result<std::unique_ptr<VoxelMap>> make_map(const MapInfo& info, const LoadOptions& options,
                                                const std::string& name) {
  if (info.counts.blocks > 0xFFFFFFFFU / 8 || (!options.capacity && memory_of(info) > options.memory_limit_bytes)) {
    return too_small(name, info);
  }
  try {
    return std::make_unique<VoxelMap>(info.grid, options.capacity.value_or(capacity_of(info)));
  } catch (const std::bad_alloc&) {
    return too_small(name, info);
  }
}

/// Decodes one chunk wholly, then writes its blocks.
hal::Result<void> load_chunk(const ChunkView& chunk, BlockDecoder& decoder, VoxelMap& map, const MapInfo& info,
                             const std::string& name) {
  const auto decoded = decoder.decode(chunk.payload);
  const auto fail = [&](Reason reason, const std::string& what) {
    return Error{reason, fmt::format("{}: chunk at byte {}: {}; the file is damaged, take another copy or map again",
                                     name, chunk.entry.offset, what)};
  };
  if (!decoded) return fail(decoded.error().reason, decoded.error().text);
  const std::span<const StoredBlock> blocks = decoded.value();
  if (blocks.size() != chunk.entry.blocks || blocks.front().key != chunk.entry.first_key ||
      blocks.back().key != chunk.entry.last_key) {
    return fail(Reason::malformed, "its blocks are not the announced ones");
  }
  for (const StoredBlock& block : blocks) {
    if (!map.write_block(block.key, block.values)) return too_small(name, info);
  }
  return {};
}

}  // namespace

hal::Result<SaveReport> encode_map(const VoxelMap& map, const MapFileMeta& meta, const ByteSink& sink, int zstd_level) {
  const std::vector<BlockKey> keys = map.sorted_keys();
  const MapInfo info = describe(map, meta, keys);
  SaveReport report{0, info.counts};
  const auto write = [&](ByteSpan bytes) {
    report.file_bytes += bytes.size();
    return sink(bytes);
  };
  const Bytes header = encode_header(info);
  if (const auto done = write(header); !done) return done.error();
  std::uint32_t crc_chain = 0;
  chain_crc(crc_chain, stored_crc(header));
  BlockEncoder encoder(zstd_level);
  std::vector<ChunkEntry> index;
  for (std::size_t begin = 0; begin < keys.size(); begin += kMaxGroupBlocks) {
    const auto group = std::span(keys).subspan(begin, std::min<std::size_t>(kMaxGroupBlocks, keys.size() - begin));
    const ChunkEntry entry{report.file_bytes, group.front(), group.back(), static_cast<std::uint32_t>(group.size())};
    const Bytes& payload = encoder.encode(group, map);
    std::uint32_t crc = 0;
    const Bytes chunk_header = encode_chunk_header(entry, payload, crc);
    chain_crc(crc_chain, crc);
    index.push_back(entry);
    if (const auto done = write(chunk_header); !done) return done.error();
    if (const auto done = write(payload); !done) return done.error();
  }
  if (const auto done = write(encode_index(index, report.file_bytes, crc_chain)); !done) return done.error();
  return report;
}

hal::Result<LoadedMap> decode_map(ByteSpan bytes, const std::string& name, const LoadOptions& options) {
  auto header = decode_header(bytes, name);
  if (!header) return header.error();
  LoadedMap loaded;
  loaded.info = header.value();
  loaded.info.file_bytes = bytes.size();
  if (loaded.info.chunks > bytes.size() / kChunkHeaderBytes) {
    return Error{Reason::truncated,
                 fmt::format("{}: byte {}: ends before its {} chunks; take another copy or map again", name,
                             bytes.size(), loaded.info.chunks)};
  }
  auto map = make_map(loaded.info, options, name);
  if (!map) return map.error();
  loaded.map = std::move(map).value();
  BlockDecoder decoder;
  std::vector<ChunkEntry> index;
  std::uint32_t crc_chain = 0;
  chain_crc(crc_chain, stored_crc(bytes));
  std::size_t offset = kMapHeaderBytes;
  for (std::uint32_t i = 0; i < loaded.info.chunks; ++i) {
    const auto chunk = decode_chunk_header(bytes, offset, name);
    if (!chunk) return chunk.error();
    if (!index.empty() && chunk.value().entry.first_key <= index.back().last_key) {
      return Error{Reason::malformed,
                   fmt::format("{}: byte {}: chunks out of order; take another copy or map again", name, offset)};
    }
    if (const auto done = load_chunk(chunk.value(), decoder, *loaded.map, loaded.info, name); !done)
      return done.error();
    index.push_back(chunk.value().entry);
    chain_crc(crc_chain, chunk.value().crc);
    offset = chunk.value().end_offset;
  }
  if (const auto done = check_index(bytes, offset, index, crc_chain, name); !done) return done.error();
  const MapCounts counts = loaded.map->counts();
  const MapCounts& said = loaded.info.counts;
  if (counts.occupied != said.occupied || counts.free != said.free || counts.coloured != said.coloured ||
      counts.blocks != said.blocks) {
    return Error{Reason::malformed,
                 fmt::format("{}: byte 88: holds {} occupied and {} free voxels, but announces {} and {}; take "
                             "another copy or map again",
                             name, counts.occupied, counts.free, said.occupied, said.free)};
  }
  return loaded;
}

}  // namespace g3d::mapper
