// SPDX-License-Identifier: Apache-2.0
// One cell of a map of surfaces: where a sample belongs, what it adds, and the piece of surface that the sums make.
// Inline and without a library's mathematics: the CPU and a card run the same lines (see mapper/cuda/kernels.cu). Sums
// are integers, so their order does not matter.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "mapper/align/depth_sample.hpp"

namespace g3d::mapper::align {

/// Where a surface passes: the plane through `point_m` across `normal`.
struct SurfacePiece {
  Vector3f point_m;
  Vector3f normal;  ///< unit, towards free space
};

struct SurfaceCell {
  std::uint64_t key = 0;    ///< 0: nothing here
  std::uint32_t frame = 0;  ///< the last one that added to it
  std::int32_t weight = 0;
  std::int64_t born_ns = 0;     ///< kUnsteady: came into free space, or has left
  std::int32_t place[3] = {};   ///< sums of weight * offset from the cell's low corner, in 1/1024 of a cell
  std::int32_t normal[3] = {};  ///< sums of weight * normal * 1024
};
inline constexpr std::int64_t kUnsteady = std::numeric_limits<std::int64_t>::max();

/// What all cells of a map have in common.
struct SurfaceRule {
  float cell_m = 0.08F;
  float least_sample_weight = 0.0008F;  ///< samples below are matched, but not added: they would fill cells beside
  float least_coherence = 0.9F;         ///< length of a cell's mean normal; below, it holds a corner or a ball
};

inline constexpr int kPlaceParts = 1024;
inline constexpr float kNormalParts = 1024.0F;
// Above, the sums are halved before the next frame adds to them: what was seen long ago counts less, and no sum
// overflows even if all 19,200 samples of a frame fall into one cell: (2048 + 19200 * 33) * 1024 < 2^31.
inline constexpr std::int32_t kMostCellWeight = 1 << 11;
inline constexpr std::int32_t kMostSampleWeight = 32;
inline constexpr std::int32_t kLeastCellWeight = 4;

struct CellIndex {
  std::int32_t x, y, z;
};

/// 20 bits per axis and three for the way it faces; never 0.
[[nodiscard]] inline std::uint64_t surface_key(const CellIndex& c, int facing) {
  const auto part = [](std::int32_t k) { return static_cast<std::uint64_t>(k + (1 << 19)) & 0xFFFFFU; };
  return part(c.x) | part(c.y) << 20 | part(c.z) << 40 | static_cast<std::uint64_t>(facing + 1) << 60;
}

[[nodiscard]] inline CellIndex index_of(std::uint64_t key) {
  const auto part = [&](int shift) { return static_cast<std::int32_t>(key >> shift & 0xFFFFFU) - (1 << 19); };
  return {part(0), part(20), part(40)};
}

/// Where the search for a key begins, in a table of a power of two slots.
[[nodiscard]] inline std::size_t home_of(std::uint64_t key, std::size_t mask) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 24) & mask;
}

/// 0..5: +x -x +y -y +z -z.
[[nodiscard]] inline int facing_of(const Vector3f& n) {
  const float ax = __builtin_fabsf(n[0]);
  const float ay = __builtin_fabsf(n[1]);
  const float az = __builtin_fabsf(n[2]);
  if (ax >= ay && ax >= az) return n[0] < 0.0F ? 1 : 0;
  if (ay >= az) return n[1] < 0.0F ? 3 : 2;
  return n[2] < 0.0F ? 5 : 4;
}

/// A point in cells, and the low corner of the one it lies in.
struct CellPlace {
  Vector3f q;
  Vector3f low;
};
/// False beyond the keys' room (40 km at 8 cm), and for what is no number.
[[nodiscard]] inline bool place_of(const SurfaceRule& rule, const Vector3f& point_m, CellPlace& place) {
  constexpr float kFarthest_cells = 500'000.0F;
  const float per_cell = 1.0F / rule.cell_m;
  for (std::size_t i = 0; i < 3; ++i) {
    place.q[i] = point_m[i] * per_cell;
    if (!(__builtin_fabsf(place.q[i]) < kFarthest_cells)) return false;
    place.low[i] = __builtin_floorf(place.q[i]);
  }
  return true;
}
[[nodiscard]] inline CellIndex index_of(const CellPlace& place) {
  return {static_cast<std::int32_t>(place.low[0]), static_cast<std::int32_t>(place.low[1]),
          static_cast<std::int32_t>(place.low[2])};
}
[[nodiscard]] inline std::uint64_t key_at(const CellPlace& place, const Vector3f& normal) {
  return surface_key(index_of(place), facing_of(normal));
}

/// 1 mm of sigma weighs 32, 5.6 mm and more weigh 1.
[[nodiscard]] inline std::int32_t whole_weight(float sample_weight) {
  return static_cast<std::int32_t>(sample_weight * static_cast<float>(kMostSampleWeight)) + 1;
}
[[nodiscard]] inline std::int32_t place_term(const CellPlace& place, std::size_t axis, std::int32_t weight) {
  return weight * static_cast<std::int32_t>((place.q[axis] - place.low[axis]) * static_cast<float>(kPlaceParts));
}
[[nodiscard]] inline std::int32_t normal_term(const Vector3f& normal, std::size_t axis, std::int32_t weight) {
  return weight * static_cast<std::int32_t>(normal[axis] * kNormalParts);
}

/// Whatever samples a cell was made of, it holds no more than this.
[[nodiscard]] inline bool is_sound(const SurfaceCell& cell) {
  const std::uint64_t facing = cell.key >> 60 & 0x7U;
  if (facing == 0 || facing > 6 || cell.key >> 63 != 0 || cell.weight < 1) return false;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t most = (std::int64_t{cell.weight} + 1) * kPlaceParts;  // halves are cut
    if (cell.place[i] < 0 || cell.place[i] > most || cell.normal[i] > most || cell.normal[i] < -most) return false;
  }
  return true;
}

inline void halve(SurfaceCell& cell) {
  cell.weight /= 2;
  for (int i = 0; i < 3; ++i) {
    cell.place[i] /= 2;
    cell.normal[i] /= 2;
  }
}

/// Shorter than one where the cell holds a corner.
[[nodiscard]] inline Vector3f mean_normal(const SurfaceCell& cell) {
  const float w = static_cast<float>(cell.weight);
  Vector3f mean;
  for (std::size_t i = 0; i < 3; ++i) mean[i] = static_cast<float>(cell.normal[i]) / (w * kNormalParts);
  return mean;
}

[[nodiscard]] inline Vector3f mean_point_m(const SurfaceRule& rule, const SurfaceCell& cell) {
  const float w = static_cast<float>(cell.weight);
  const CellIndex index = index_of(cell.key);
  const std::int32_t low[3] = {index.x, index.y, index.z};
  Vector3f mean_m;
  for (std::size_t i = 0; i < 3; ++i) {
    // A sum of offsets that were cut to whole parts is half a part too low.
    const float offset = (static_cast<float>(cell.place[i]) / w + 0.5F) / static_cast<float>(kPlaceParts);
    mean_m[i] = (static_cast<float>(low[i]) + offset) * rule.cell_m;
  }
  return mean_m;
}

/// False: too little to be sure of.
[[nodiscard]] inline bool piece_of(const SurfaceRule& rule, const SurfaceCell& cell, SurfacePiece& piece) {
  if (cell.weight < kLeastCellWeight) return false;
  piece.normal = mean_normal(cell);
  const Vector3f& n = piece.normal;
  const float length = __builtin_sqrtf(0.0F + n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (length < rule.least_coherence) return false;
  for (std::size_t i = 0; i < 3; ++i) piece.normal[i] /= length;
  piece.point_m = mean_point_m(rule, cell);
  return true;
}

/// The piece nearest to a point in the cell of the point and in those before and behind it, facing like `normal`, and
/// first seen at `born_by_ns` at the latest. `look_up(key)`: the cell, nullptr if there is none. False: none.
template <typename LookUp>
[[nodiscard]] inline bool nearest_piece(const SurfaceRule& rule, const Vector3f& point_m, const Vector3f& normal,
                                        std::int64_t born_by_ns, const LookUp& look_up, SurfacePiece& best) {
  CellPlace place;
  if (!place_of(rule, point_m, place)) return false;
  CellIndex index = index_of(place);
  const int facing = facing_of(normal);
  std::int32_t& along = facing < 2 ? index.x : facing < 4 ? index.y : index.z;
  bool found = false;
  float least = 1e9F;
  const std::int32_t centre = along;
  for (int step = -1; step <= 1; ++step) {
    along = centre + step;
    const SurfaceCell* cell = look_up(surface_key(index, facing));
    if (cell == nullptr || cell->born_ns > born_by_ns) continue;
    SurfacePiece piece;
    if (!piece_of(rule, *cell, piece)) continue;
    const float distance = __builtin_fabsf(piece.normal[0] * (point_m[0] - piece.point_m[0]) +
                                           piece.normal[1] * (point_m[1] - piece.point_m[1]) +
                                           piece.normal[2] * (point_m[2] - piece.point_m[2]));
    if (distance < least) {
      least = distance;
      best = piece;
      found = true;
    }
  }
  return found;
}

}  // namespace g3d::mapper::align
