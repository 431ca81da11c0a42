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

MapInfo describe(const BlockSource& source, const MapFileMeta& meta, const SourceSize& size) {
  MapInfo info;
  info.grid = source.grid();
  info.meta = meta;
  info.counts = size.counts;
  info.dense_blocks = size.needed.planes;
  info.colour_bricks = size.needed.colour_bricks;
  info.chunks = static_cast<std::uint32_t>((size.counts.blocks + kMaxGroupBlocks - 1) / kMaxGroupBlocks);
  return info;
}

/// Header, chunks, index, in this order.
class MapWriter {
 public:
  MapWriter(const MapInfo& info, const ByteSink& sink, int zstd_level)
      : info_(info), sink_(sink), encoder_(zstd_level), report_{0, info_.counts} {}

  hal::Result<void> begin() {
    const Bytes header = encode_header(info_);
    chain_crc(crc_chain_, stored_crc(header));
    return write(header);
  }
  hal::Result<void> chunk(std::span<const BlockKey> keys, const VoxelMap& map) {
    const ChunkEntry entry{report_.file_bytes, keys.front(), keys.back(), static_cast<std::uint32_t>(keys.size())};
    const Bytes& payload = encoder_.encode(keys, map);
    std::uint32_t crc = 0;
    const Bytes chunk_header = encode_chunk_header(entry, payload, crc);
    chain_crc(crc_chain_, crc);
    index_.push_back(entry);
    if (auto done = write(chunk_header); !done) return done;
    return write(payload);
  }
  hal::Result<SaveReport> end() {
    if (const auto done = write(encode_index(index_, report_.file_bytes, crc_chain_)); !done) return done.error();
    return report_;
  }

 private:
  hal::Result<void> write(ByteSpan bytes) {
    report_.file_bytes += bytes.size();
    return sink_(bytes);
  }

  MapInfo info_;
  const ByteSink& sink_;
  BlockEncoder encoder_;
  SaveReport report_;
  std::uint32_t crc_chain_ = 0;
  std::vector<ChunkEntry> index_;
};

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
  MapWriter writer(describe(map, meta, keys), sink, zstd_level);
  if (const auto done = writer.begin(); !done) return done.error();
  for (std::size_t begin = 0; begin < keys.size(); begin += kMaxGroupBlocks) {
    const std::size_t count = std::min<std::size_t>(kMaxGroupBlocks, keys.size() - begin);
    if (const auto done = writer.chunk(std::span(keys).subspan(begin, count), map); !done) return done.error();
  }
  return writer.end();
}

// Two passes, as the header counts what follows. The encoder reads from a map: a small one takes a chunk at a time.
hal::Result<SaveReport> encode_map(const BlockSource& source, const MapFileMeta& meta, const ByteSink& sink,
                                   int zstd_level) {
  const auto size = measure(source);
  if (!size) return size.error();
  MapWriter writer(describe(source, meta, size.value()), sink, zstd_level);
  if (const auto done = writer.begin(); !done) return done.error();
  VoxelMap staged(source.grid(), {kMaxGroupBlocks, kMaxGroupBlocks, kMaxGroupBlocks * kBricksPerBlock});
  std::vector<BlockKey> keys;
  const auto flush = [&]() -> hal::Result<void> {
    if (keys.empty()) return {};
    auto done = writer.chunk(keys, staged);
    staged.clear();
    keys.clear();
    return done;
  };
  SourceSize seen;
  const auto visited = source.visit_regions([&](std::span<const StoredBlock> blocks) -> hal::Result<void> {
    for (const StoredBlock& block : blocks) {
      seen.add(block.values);
      (void)staged.write_block(block.key, block.values);  // has room for every block of a chunk
      keys.push_back(block.key);
      if (keys.size() < kMaxGroupBlocks) continue;
      if (auto done = flush(); !done) return done;
    }
    return {};
  });
  if (!visited) return visited.error();
  if (const auto done = flush(); !done) return done.error();
  if (!(seen.counts == size.value().counts)) {
    return Error{Reason::io_error, "a part of the map became unreadable while it was being saved; check the disk"};
  }
  return writer.end();
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
