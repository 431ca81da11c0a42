// SPDX-License-Identifier: Apache-2.0
// A group of blocks <-> compressed bytes: what a chunk of `map.g3d` holds and what paging writes. Bit-identical both
// ways.
//
// The blocks' parts are pulled apart into streams of one kind, each its own zstd frame:
//   keys (differences), kinds (uniform level or "dense"), fifteen streams of level residuals (level_codec.hpp),
//   which occupied voxels have a colour, and G, R-G, B-G as differences to the coloured voxel before.
// Layout: per stream u32 raw bytes, u32 packed bytes; then the packed streams one after the other.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/result.hpp"
#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace g3d::mapper {

inline constexpr std::uint32_t kMaxGroupBlocks = 4096;
inline constexpr int kDefaultZstdLevel = 6;

/// A block with all that the map keeps of it: codes with kHasColourBit.
struct StoredBlock {
  BlockKey key = 0;
  BlockValues values{};
};

/// Working memory is kept between calls. One thread each.
class BlockEncoder {
 public:
  explicit BlockEncoder(int zstd_level = kDefaultZstdLevel);
  ~BlockEncoder();
  BlockEncoder(const BlockEncoder&) = delete;
  BlockEncoder& operator=(const BlockEncoder&) = delete;

  /// `keys`: ascending, at most kMaxGroupBlocks, all in the map. Valid until the next call.
  [[nodiscard]] const Bytes& encode(std::span<const BlockKey> keys, const VoxelMap& map);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

class BlockDecoder {
 public:
  BlockDecoder();
  ~BlockDecoder();
  BlockDecoder(const BlockDecoder&) = delete;
  BlockDecoder& operator=(const BlockDecoder&) = delete;

  /// Blocks in ascending order of key, valid until the next call. Hostile bytes give an error that says what is wrong
  /// (without file and remedy: the caller knows them). Nothing is returned unless everything is valid.
  [[nodiscard]] hal::Result<std::span<const StoredBlock>> decode(ByteSpan bytes);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace g3d::mapper
