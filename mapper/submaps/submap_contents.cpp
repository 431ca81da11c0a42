// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_contents.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "mapper/files/block_codec.hpp"

namespace g3d::mapper::submaps {
namespace {

using hal::Error;
using hal::Reason;

constexpr int kShelfZstdLevel = 1;  // put away and fetched while somebody maps

void put_map(Bytes& out, const VoxelMap* map, BlockEncoder& encoder) {
  put(out, map != nullptr ? map->grid().resolution_m : 0.0F);
  if (map == nullptr) return;
  const std::vector<BlockKey> keys = map->sorted_keys();
  put(out, static_cast<std::uint32_t>(keys.size()));
  for (std::size_t first = 0; first < keys.size(); first += kMaxGroupBlocks) {
    const std::size_t count = std::min<std::size_t>(kMaxGroupBlocks, keys.size() - first);
    const Bytes& group = encoder.encode(std::span(keys).subspan(first, count), *map);
    put(out, static_cast<std::uint32_t>(group.size()));
    put_bytes(out, group);
  }
}

hal::Result<std::unique_ptr<VoxelMap>> take_map(ByteReader& in, BlockDecoder& decoder) {
  constexpr std::uint32_t kMostBlocks = 1U << 24;
  const auto cut_off = [] { return Error{Reason::truncated, "a map of the submap is cut off"}; };
  float resolution_m = 0.0F;
  if (!in.take(resolution_m)) return cut_off();
  if (resolution_m == 0.0F) return std::unique_ptr<VoxelMap>{};
  if (!std::isfinite(resolution_m) || resolution_m < 0.0F) return Error{Reason::malformed, "no such resolution"};
  std::uint32_t blocks = 0;
  if (!in.take(blocks)) return cut_off();
  if (blocks > kMostBlocks) return Error{Reason::too_large, "more blocks than any submap has"};
  auto map = map_for_blocks(Grid{resolution_m}, blocks);
  for (std::uint32_t read = 0; read < blocks;) {
    std::uint32_t bytes = 0;
    ByteSpan packed;
    if (!in.take(bytes) || !in.take_bytes(bytes, packed)) return cut_off();
    const auto group = decoder.decode(packed);
    if (!group) return group.error();
    if (group.value().empty()) return Error{Reason::malformed, "a group without blocks"};
    for (const StoredBlock& block : group.value()) {
      if (!map->write_block(block.key, block.values)) return Error{Reason::malformed, "more blocks than announced"};
    }
    read += static_cast<std::uint32_t>(group.value().size());
  }
  return map;
}

}  // namespace

std::unique_ptr<VoxelMap> map_for_blocks(const Grid& grid, std::size_t blocks) {
  const auto count = static_cast<std::uint32_t>(std::max<std::size_t>(blocks, 1));
  return std::make_unique<VoxelMap>(grid, MapCapacity{count, count, count * kBricksPerBlock});
}

std::uint64_t SubmapContents::memory_bytes() const {
  return (voxels != nullptr ? voxels->memory().used_bytes : 0) + surfaces.size() * sizeof(align::DepthSample) +
         (space != nullptr ? space->memory().used_bytes : 0);
}

Bytes to_bytes(const SubmapContents& contents) {
  Bytes out;
  put(out, static_cast<std::uint32_t>(contents.surfaces.size()));
  put(out, static_cast<std::uint32_t>(sizeof(align::DepthSample)));
  for (const align::DepthSample& sample : contents.surfaces) put(out, sample);
  BlockEncoder encoder(kShelfZstdLevel);
  put_map(out, contents.voxels.get(), encoder);
  put_map(out, contents.space.get(), encoder);
  return out;
}

hal::Result<SubmapContents> from_bytes(ByteSpan bytes) {
  ByteReader in(bytes);
  std::uint32_t count = 0;
  std::uint32_t size = 0;
  if (!in.take(count) || !in.take(size)) return Error{Reason::truncated, "no count of surfaces"};
  if (size != sizeof(align::DepthSample)) return Error{Reason::malformed, "surfaces of another size"};
  if (in.left() / size < count) return Error{Reason::truncated, "the surfaces are cut off"};
  SubmapContents contents;
  contents.surfaces.resize(count);
  for (align::DepthSample& sample : contents.surfaces) (void)in.take(sample);
  BlockDecoder decoder;
  for (std::unique_ptr<VoxelMap>* map : {&contents.voxels, &contents.space}) {
    auto taken = take_map(in, decoder);
    if (!taken) return taken.error();
    *map = std::move(taken).value();
  }
  if (in.left() != 0) return Error{Reason::malformed, "bytes are left over"};
  if (contents.voxels == nullptr) return Error{Reason::malformed, "a submap without voxels"};
  return contents;
}

}  // namespace g3d::mapper::submaps
