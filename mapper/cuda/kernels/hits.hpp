// SPDX-License-Identifier: Apache-2.0
// Every trusted reading goes to the voxel that it falls into. First blocks are marked and numbered, one launch later
// pixels go to the records: nobody waits for a number that another thread is about to hand out.
// A record holds one word per voxel, the least of what its pixels offer:
//   pixel index                may give its colour
//   pixel index | kNoColour    was measured, but lies at a depth edge (or there is no colour image)
//   all ones                   nothing was measured
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kNoColour = 0x80000000U;
inline constexpr std::uint32_t kNoHit = 0xFFFFFFFFU;
inline constexpr int kTileColumns = 32;
inline constexpr int kTileRows = kPixelThreads / kTileColumns;

/// See cpu/kernels/image_rows.cpp.
inline G3D_GPU bool is_depth_edge(std::uint32_t d, std::uint32_t n) {
  const std::uint32_t nearer = least(d, n);
  return most(d, n) - nearer > (nearer >> 5) + (nearer >> 7);
}

inline G3D_GPU bool gives_colour(const FrameParams& f, const Memory& m, int u, int v) {
  const std::uint16_t* pixel = m.depth + v * f.width_px + u;
  const std::uint32_t d = *pixel;
  // At the border the neighbour that is not there is the pixel itself.
  return !((u > 0 && is_depth_edge(d, pixel[-1])) || (u + 1 < f.width_px && is_depth_edge(d, pixel[1])) ||
           (v > 0 && is_depth_edge(d, pixel[-f.width_px])) ||
           (v + 1 < f.height_px && is_depth_edge(d, pixel[f.width_px])));
}

/// Where a pixel's reading lies in the frame's box.
struct PixelHit {
  std::uint32_t block_id;  ///< kNone: no trusted reading
  std::uint32_t place;     ///< M & 511
};

inline G3D_GPU PixelHit unproject(const FrameParams& f, const Memory& m, int u, int v) {
  const int d = m.depth[v * f.width_px + u];
  if (d < f.near_raw || d > f.far_raw || d == 0) return {kNone, 0};
  const float z = static_cast<float>(d) * f.metres_per_unit;
  const float column = m.column_slope[u];
  const float row = m.row_slope[v];
  std::int32_t k[3];
  for (int axis = 0; axis < 3; ++axis) {
    const float* R = f.rotation + 3 * axis;
    const float row_part = R[1] * row + R[2];
    const float p_m = (row_part + column * R[0]) * z + f.translation_m[axis];
    k[axis] = cell_of(p_m / f.resolution_m, f.origin[axis]);
    // The box has room for every trusted reading; a damaged frame must not write beside it.
    if (k[axis] < 0 || k[axis] >= 8 * f.blocks[axis]) return {kNone, 0};
  }
  return {block_id_at(f, k[0] >> 3, k[1] >> 3, k[2] >> 3), place_at(k[0] & 7, k[1] & 7, k[2] & 7)};
}

struct HitTile {
  std::uint32_t block_id[kTileRows][kTileColumns];
  std::uint16_t code[kTileRows][kTileColumns];  ///< place << 1 | may give its colour
};

/// Is there a pixel with a lower index in the tile, beside or above, that says the same? Then it has said it all.
inline G3D_GPU bool is_repeat(const HitTile& tile, int x, int y, bool whole_block) {
  const auto same = [&](int nx, int ny) {
    return nx >= 0 && nx < kTileColumns && ny >= 0 && tile.block_id[ny][nx] == tile.block_id[y][x] &&
           (whole_block || tile.code[ny][nx] == tile.code[y][x]);
  };
  return same(x - 1, y) || same(x - 1, y - 1) || same(x, y - 1) || same(x + 1, y - 1);
}

inline G3D_GPU void load_tile(const FrameParams& f, const Memory& m, int tile, int t, HitTile& s, bool with_codes) {
  const int across = tiles(f.width_px, kTileColumns);
  const int x = t % kTileColumns;
  const int y = t / kTileColumns;
  const int u = tile % across * kTileColumns + x;
  const int v = tile / across * kTileRows + y;
  PixelHit hit{kNone, 0};
  if (u < f.width_px && v < f.height_px) hit = unproject(f, m, u, v);
  s.block_id[y][x] = hit.block_id;
  if (!with_codes) return;
  const bool coloured = hit.block_id != kNone && f.with_colour != 0 && gives_colour(f, m, u, v);
  s.code[y][x] = static_cast<std::uint16_t>(hit.place << 1 | (coloured ? 1U : 0U));
}

/// Numbers the blocks in which the tile's pixels lie.
inline G3D_GPU void mark_hit_blocks(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED HitTile s;
  block.each([&](int t) { load_tile(f, m, tile, t, s, false); });
  block.each([&](int t) {
    const int x = t % kTileColumns;
    const int y = t / kTileColumns;
    const std::uint32_t id = s.block_id[y][x];
    if (id == kNone || is_repeat(s, x, y, true)) return;
    std::uint32_t* entry = m.record_of_block + id;
    if (*static_cast<volatile std::uint32_t*>(entry) != 0 || atomic_cas(entry, 0U, kNone) != 0) return;
    const std::uint32_t record = atomic_add(&m.input->counters.records, 1U);
    m.hit_blocks[record] = id;
    *entry = record + 1;
  });
}

/// Pixels to records.
inline G3D_GPU void scatter_hits(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED HitTile s;
  block.each([&](int t) { load_tile(f, m, tile, t, s, true); });
  block.each([&](int t) {
    const int x = t % kTileColumns;
    const int y = t / kTileColumns;
    const std::uint32_t id = s.block_id[y][x];
    if (id == kNone || is_repeat(s, x, y, false)) return;
    const int across = tiles(f.width_px, kTileColumns);
    const int u = tile % across * kTileColumns + x;
    const int v = tile / across * kTileRows + y;
    const std::uint32_t pixel = static_cast<std::uint32_t>(v * f.width_px + u);
    const std::uint32_t code = s.code[y][x];
    std::uint32_t* word = m.hits + static_cast<std::size_t>(m.record_of_block[id] - 1) * kVoxels + (code >> 1);
    atomic_min(word, (code & 1U) != 0 ? pixel : pixel | kNoColour);
  });
}

}  // namespace g3d::mapper::cuda
