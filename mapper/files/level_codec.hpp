// SPDX-License-Identifier: Apache-2.0
// Level planes as small residuals: every voxel is predicted from its three lower neighbours (x-1, y-1, z-1), which come
// earlier in Morton order, also across blocks. Residuals go to one of fifteen streams by how well the neighbours agree
// and by what they say, so that a general compressor sees streams of one kind each: long runs of zeros here, noise
// there.
#pragma once

#include <array>
#include <cstdint>

#include "mapper/files/bytes.hpp"
#include "mapper/voxel_map.hpp"

namespace g3d::mapper {

inline constexpr int kLevelStreams = 15;
using LevelStreams = std::array<Bytes, kLevelStreams>;

/// The planes of the three blocks below a block; unknown_plane() where there is none.
struct LowerPlanes {
  const LevelPlane* x = nullptr;
  const LevelPlane* y = nullptr;
  const LevelPlane* z = nullptr;
};

/// A plane whose 512 levels are all `level` (0..32).
[[nodiscard]] const LevelPlane& constant_plane(std::uint8_t level);

/// Appends the residuals of 512 levels (0..32 each, no spare bits).
void encode_levels(const LevelPlane& levels, const LowerPlanes& lower, LevelStreams& out);

/// Takes residuals from the streams' fronts.
class LevelDecoder {
 public:
  explicit LevelDecoder(const std::array<ByteSpan, kLevelStreams>& streams) : streams_(streams) {}
  /// False if a stream ends too early or holds a residual above 32; `out` is then unspecified.
  [[nodiscard]] bool decode(const LowerPlanes& lower, LevelPlane& out);
  [[nodiscard]] bool at_end() const;

 private:
  std::array<ByteSpan, kLevelStreams> streams_;
  std::array<std::size_t, kLevelStreams> places_{};
};

}  // namespace g3d::mapper
