// SPDX-License-Identifier: Apache-2.0
// Every trusted reading goes to the voxel that it falls into. First blocks are marked and numbered, one launch later
// pixels go to the records: nobody waits for a number that another thread is about to hand out.
// A record holds one word per voxel, the least of what its pixels offer:
//   pixel index                may give its colour
//   pixel index | kNoColour    was measured, but lies at a depth edge (or there is no colour image)
//   kHeld                      a reading too near to be trusted: no ray frees the voxel
//   all ones                   nothing was measured
#pragma once

#include "mapper/cuda/kernels/common.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kNoColour = 0x80000000U;
inline constexpr std::uint32_t kHeld = 0xFFFFFFFEU;
inline constexpr std::uint32_t kNoHit = 0xFFFFFFFFU;
[[nodiscard]] constexpr bool is_hit(std::uint32_t word) { return word < kHeld; }
inline constexpr int kTileColumns = 32;
inline constexpr int kTileRows = 32;
inline constexpr int kTileShare = kTileColumns * kTileRows / kPixelThreads;  ///< pixels of a thread, in different rows

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
  std::uint32_t block_id;  ///< kNone: no reading up to far_raw
  std::uint32_t place;     ///< M & 511
};

inline G3D_GPU PixelHit unproject(const FrameParams& f, const Memory& m, int u, int v, int reading) {
  if (reading > f.far_raw || reading == 0) return {kNone, 0};
  const float z = static_cast<float>(reading) * f.metres_per_unit;
  const float column = m.column_slope[u];
  const float row = m.row_slope[v];
  std::uint32_t block_id = 0;
  std::uint32_t place = 0;
#pragma GCC unroll 1
  for (int axis = 2; axis >= 0; --axis) {
    const float* R = f.rotation + 3 * axis;
    const float row_part = R[1] * row + R[2];
    const float p_m = (row_part + column * R[0]) * z + f.translation_m[axis];
    const std::int32_t k = cell_of(p_m / f.resolution_m, f.origin[axis]);
    // The box has room for every trusted reading; a damaged frame must not write beside it.
    if (k < 0 || k >= 8 * f.blocks[axis]) return {kNone, 0};
    block_id = block_id * static_cast<std::uint32_t>(f.blocks[axis]) + static_cast<std::uint32_t>(k >> 3);
    place = place << 1 | spread_three(static_cast<std::uint32_t>(k & 7));
  }
  return {block_id, place};
}

/// What the pixels of a tile say, with a border that says nothing.
struct HitTile {
  std::uint32_t block_id[kTileRows + 1][kTileColumns + 2];
  std::uint16_t code[kTileRows + 1][kTileColumns + 2];  ///< place << 2 | too near << 1 | may give its colour
  std::uint32_t found;                                  ///< blocks that nobody had numbered
  std::uint32_t first_record;
};
inline G3D_GPU void clear_border(HitTile& tile, int t) {
  if (t < kTileColumns + 2) tile.block_id[0][t] = kNone;
  if (t < kTileRows) tile.block_id[t + 1][0] = kNone;
  if (t < kTileRows) tile.block_id[t + 1][kTileColumns + 1] = kNone;
}

/// Is there a pixel with a lower index in the tile, beside or above, that says the same? Then it has said it all.
inline G3D_GPU bool is_repeat(const HitTile& tile, int x, int y, bool whole_block) {
  const std::uint32_t id = tile.block_id[y + 1][x + 1];
  const std::uint32_t code = whole_block ? 0U : tile.code[y + 1][x + 1];
  constexpr int kBeside[4][2] = {{0, 1}, {0, 0}, {1, 0}, {2, 0}};
  bool found = false;
#pragma GCC unroll 4
  for (const auto& n : kBeside) {
    const std::uint32_t other = whole_block ? 0U : tile.code[y + n[1]][x + n[0]];
    found |= tile.block_id[y + n[1]][x + n[0]] == id && other == code;
  }
  return found;
}

/// Column and row in its tile of a thread's k-th pixel.
[[nodiscard]] constexpr int tile_x(int t) { return t % kTileColumns; }
[[nodiscard]] constexpr int tile_y(int t, int k) { return t / kTileColumns + k * (kTileRows / kTileShare); }

/// The pixel itself, -1 beside the image.
inline G3D_GPU int pixel_of(const FrameParams& f, int tile, int t, int k) {
  const int across = tiles(f.width_px, kTileColumns);
  const int u = tile % across * kTileColumns + tile_x(t);
  const int v = tile / across * kTileRows + tile_y(t, k);
  return u < f.width_px && v < f.height_px ? v * f.width_px + u : -1;
}

/// Numbers the blocks in which the tile's pixels lie.
inline G3D_GPU void mark_hit_blocks(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED HitTile s;
  block.each([&](int t) {
    std::uint16_t readings[kTileShare];
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      const int pixel = pixel_of(f, tile, t, k);
      readings[k] = pixel >= 0 ? m.depth[pixel] : std::uint16_t{0};
    }
    clear_border(s, t);
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) s.code[tile_y(t, k) + 1][tile_x(t) + 1] = readings[k];
#pragma GCC unroll 1
    for (int k = 0; k < kTileShare; ++k) {
      const int pixel = pixel_of(f, tile, t, k);
      const int reading = s.code[tile_y(t, k) + 1][tile_x(t) + 1];
      PixelHit hit{kNone, 0};
      if (pixel >= 0) {
        const int u = pixel % f.width_px;
        const int v = pixel / f.width_px;
        hit = unproject(f, m, u, v, reading);
        const bool near = reading < f.near_raw;
        const bool coloured = hit.block_id != kNone && !near && f.with_colour != 0 && gives_colour(f, m, u, v);
        m.pixel_block[pixel] = hit.block_id;
        m.pixel_code[pixel] = static_cast<std::uint16_t>(hit.place << 2 | (near ? 2U : 0U) | (coloured ? 1U : 0U));
      }
      s.block_id[tile_y(t, k) + 1][tile_x(t) + 1] = hit.block_id;
    }
  });
  // All four pixels of a thread at once: each look is a long wait.
  PerThread<std::uint32_t, kPixelThreads> is_first[kTileShare];
  block.each([&](int t) {
    if (t == 0) s.found = 0;
    std::uint32_t ids[kTileShare];
    std::uint32_t found[kTileShare];
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      const std::uint32_t id = s.block_id[tile_y(t, k) + 1][tile_x(t) + 1];
      ids[k] = id == kNone || is_repeat(s, tile_x(t), tile_y(t, k), true) ? kNone : id;
      found[k] = ids[k] == kNone || *static_cast<volatile std::uint32_t*>(m.record_of_block + ids[k]) != 0 ? 1U : 0U;
    }
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      if (found[k] == 0) found[k] = atomic_cas(m.record_of_block + ids[k], 0U, kNone) + 2;
    }
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) is_first[k][t] = found[k] == 2 ? 1 : 0;
  });
  PerThread<std::uint32_t, kPixelThreads> place;  // among the tile's
  block.each([&](int t) {
    std::uint32_t count = 0;
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) count += is_first[k][t];
    place[t] = count != 0 ? atomic_add(&s.found, count) : 0;
  });
  block.each([&](int t) {
    if (t == 0) s.first_record = s.found != 0 ? atomic_add(&m.input->counters.records, s.found) : 0;
  });
  block.each([&](int t) {
    std::uint32_t record = s.first_record + place[t] + 1;
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      if (is_first[k][t] != 0) m.record_of_block[s.block_id[tile_y(t, k) + 1][tile_x(t) + 1]] = record++;
    }
  });
}

/// Pixels to records.
inline G3D_GPU void scatter_hits(const Block& block, const Memory& m, const FrameParams& f, int tile) {
  G3D_GPU_SHARED HitTile s;
  block.each([&](int t) {
    std::uint32_t ids[kTileShare];
    std::uint16_t codes[kTileShare];
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      const int pixel = pixel_of(f, tile, t, k);
      ids[k] = pixel >= 0 ? m.pixel_block[pixel] : kNone;
      codes[k] = pixel >= 0 ? m.pixel_code[pixel] : std::uint16_t{0};
    }
    clear_border(s, t);
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      s.block_id[tile_y(t, k) + 1][tile_x(t) + 1] = ids[k];
      s.code[tile_y(t, k) + 1][tile_x(t) + 1] = codes[k];
    }
  });
  block.each([&](int t) {
    const int x = tile_x(t);
    std::uint32_t records[kTileShare];
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      const std::uint32_t id = s.block_id[tile_y(t, k) + 1][x + 1];
      records[k] = id == kNone || is_repeat(s, x, tile_y(t, k), false) ? 0 : m.record_of_block[id];
    }
#pragma GCC unroll 4
    for (int k = 0; k < kTileShare; ++k) {
      if (records[k] == 0) continue;
      const std::uint32_t code = s.code[tile_y(t, k) + 1][x + 1];
      const std::uint32_t pixel = static_cast<std::uint32_t>(pixel_of(f, tile, t, k));
      std::uint32_t* word = m.hits + static_cast<std::size_t>(records[k] - 1) * kVoxels + (code >> 2);
      atomic_min(word, (code & 2U) != 0 ? kHeld : (code & 1U) != 0 ? pixel : pixel | kNoColour);
    }
  });
}

}  // namespace g3d::mapper::cuda
