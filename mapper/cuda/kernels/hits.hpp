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
  // At the border the neighbour that is not there is the pixel itself.
  const std::uint32_t d = pixel[0];
  const std::uint32_t left = pixel[u > 0 ? -1 : 0];
  const std::uint32_t right = pixel[u + 1 < f.width_px ? 1 : 0];
  const std::uint32_t above = pixel[v > 0 ? -f.width_px : 0];
  const std::uint32_t below = pixel[v + 1 < f.height_px ? f.width_px : 0];
  return !(is_depth_edge(d, left) | is_depth_edge(d, right) | is_depth_edge(d, above) | is_depth_edge(d, below));
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

/// Pixel of a thread of a tile, -1 beside the image.
inline G3D_GPU int pixel_of(const FrameParams& f, int tile, int t) {
  const int across = tiles(f.width_px, kTileColumns);
  const int u = tile % across * kTileColumns + t % kTileColumns;
  const int v = tile / across * kTileRows + t / kTileColumns;
  return u < f.width_px && v < f.height_px ? v * f.width_px + u : -1;
}

/// Numbers the blocks in which the tile's pixels lie.
inline G3D_GPU void mark_hit_blocks(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED HitTile s;
  block.each([&](int t) {
    const int pixel = pixel_of(f, tile, t);
    PixelHit hit{kNone, 0};
    if (pixel >= 0) {
      hit = unproject(f, m, pixel % f.width_px, pixel / f.width_px);
      m.pixel_block[pixel] = hit.block_id;
      m.pixel_place[pixel] = static_cast<std::uint16_t>(hit.place);
    }
    s.block_id[t / kTileColumns][t % kTileColumns] = hit.block_id;
  });
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
  block.each([&](int t) {
    const int pixel = pixel_of(f, tile, t);
    const std::uint32_t id = pixel >= 0 ? m.pixel_block[pixel] : kNone;
    s.block_id[t / kTileColumns][t % kTileColumns] = id;
    if (id == kNone) return;
    const bool coloured = f.with_colour != 0 && gives_colour(f, m, pixel % f.width_px, pixel / f.width_px);
    s.code[t / kTileColumns][t % kTileColumns] =
        static_cast<std::uint16_t>(m.pixel_place[pixel] << 1 | (coloured ? 1 : 0));
  });
  block.each([&](int t) {
    const int x = t % kTileColumns;
    const int y = t / kTileColumns;
    const std::uint32_t id = s.block_id[y][x];
    if (id == kNone || is_repeat(s, x, y, false)) return;
    const std::uint32_t pixel = static_cast<std::uint32_t>(pixel_of(f, tile, t));
    const std::uint32_t code = s.code[y][x];
    std::uint32_t* word = m.hits + static_cast<std::size_t>(m.record_of_block[id] - 1) * kVoxels + (code >> 1);
    atomic_min(word, (code & 1U) != 0 ? pixel : pixel | kNoColour);
  });
}

}  // namespace g3d::mapper::cuda
