// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/surface_map.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace g3d::mapper::align {
namespace {

constexpr int kPlaceParts = 1024;
constexpr float kNormalParts = 1024.0F;
// Above, the sums are halved before the next frame adds to them: what was seen long ago counts less, and no sum
// overflows even if all 19,200 samples of a frame fall into one cell: (2048 + 19200 * 33) * 1024 < 2^31.
constexpr std::int32_t kMostWeight = 1 << 11;
constexpr std::int32_t kMostSampleWeight = 32;
constexpr std::int32_t kLeastWeight = 4;

struct CellIndex {
  std::int32_t x, y, z;
};

/// 20 bits per axis and three for the way it faces; never 0.
std::uint64_t key_of(const CellIndex& c, int facing) {
  const auto part = [](std::int32_t k) { return static_cast<std::uint64_t>(k + (1 << 19)) & 0xFFFFFU; };
  return part(c.x) | part(c.y) << 20 | part(c.z) << 40 | static_cast<std::uint64_t>(facing + 1) << 60;
}

CellIndex index_of(std::uint64_t key) {
  const auto part = [&](int shift) { return static_cast<std::int32_t>(key >> shift & 0xFFFFFU) - (1 << 19); };
  return {part(0), part(20), part(40)};
}

/// 0..5: +x -x +y -y +z -z.
int facing_of(const Vector3f& n) {
  const float ax = std::abs(n[0]);
  const float ay = std::abs(n[1]);
  const float az = std::abs(n[2]);
  if (ax >= ay && ax >= az) return n[0] < 0.0F ? 1 : 0;
  if (ay >= az) return n[1] < 0.0F ? 3 : 2;
  return n[2] < 0.0F ? 5 : 4;
}

/// Keys have room for this many cells each way: 40 km at 8 cm. False for what is no number, too.
bool is_inside(const float (&q)[3]) {
  constexpr float kFarthest_cells = 500'000.0F;
  return std::abs(q[0]) < kFarthest_cells && std::abs(q[1]) < kFarthest_cells && std::abs(q[2]) < kFarthest_cells;
}

std::size_t spread(std::uint64_t key) { return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 24); }

}  // namespace

SurfaceMap::SurfaceMap(const SurfaceOptions& options)
    : options_(options), mask_(options.slots - 1), table_(options.slots) {
  assert((options.slots & mask_) == 0);
  table_.touch(table_.size_bytes());
}

std::optional<SurfaceMap::Place> SurfaceMap::place_of(const Vector3f& point_m) const {
  const float per_cell = 1.0F / options_.cell_m;
  Place place{{point_m[0] * per_cell, point_m[1] * per_cell, point_m[2] * per_cell}, {}};
  if (!is_inside(place.q)) return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i) place.low[i] = std::floor(place.q[i]);
  return place;
}

std::uint64_t SurfaceMap::key_at(const Place& place, const Vector3f& normal) {
  return key_of({static_cast<std::int32_t>(place.low[0]), static_cast<std::int32_t>(place.low[1]),
                 static_cast<std::int32_t>(place.low[2])},
                facing_of(normal));
}

SurfaceMap::Cell& SurfaceMap::cell_for(std::uint64_t key) {
  std::size_t at = spread(key) & mask_;
  while (table_[at].key != 0 && table_[at].key != key) at = (at + 1) & mask_;
  return table_[at];
}

void SurfaceMap::add_to(Cell& cell, const Place& place, const Vector3f& normal, std::int32_t weight) {
  cell.weight += weight;
  for (std::size_t i = 0; i < 3; ++i) {
    cell.place[i] += weight * static_cast<std::int32_t>((place.q[i] - place.low[i]) * static_cast<float>(kPlaceParts));
    cell.normal[i] += weight * static_cast<std::int32_t>(normal[i] * kNormalParts);
  }
}

void SurfaceMap::add(std::span<const DepthSample> samples, const hal::RigidTransform& T, hal::TimeNs stamp_ns,
                     const SeenSpace* space) {
  ++frame_;
  for (const DepthSample& sample : samples) {
    if (sample.weight < options_.least_sample_weight) continue;
    const Vector3f arm = rotated(T, sample.point_m);
    const Vector3f point_m{arm[0] + T.translation_m[0], arm[1] + T.translation_m[1], arm[2] + T.translation_m[2]};
    const Vector3f n = rotated(T, sample.normal);
    const auto place = place_of(point_m);
    if (!place) {
      ++refused_;
      continue;
    }
    const std::uint64_t key = key_at(*place, n);
    Cell& cell = cell_for(key);
    if (cell.key == 0) {
      if (count_ * 4 >= table_.size() * 3) {
        ++refused_;
        continue;
      }
      cell.key = key;
      cell.born_ns = stamp_ns;
      ++count_;
      if (space != nullptr && space->is_free(point_m)) {
        cell.born_ns = kUnsteady;
        ++unsteady_;
      }
    }
    if (cell.frame != frame_) {
      cell.frame = frame_;
      if (cell.weight > kMostWeight) halve(cell);
    }
    // 1 mm of sigma weighs 32, 5.6 mm and more weigh 1.
    add_to(cell, *place, n, static_cast<std::int32_t>(sample.weight * static_cast<float>(kMostSampleWeight)) + 1);
  }
}

void SurfaceMap::forget_gone(const SeenSpace& space) {
  const std::size_t end = next_swept_ + table_.size() / kSweeps;
  for (; next_swept_ < end; ++next_swept_) {
    Cell& cell = table_[next_swept_];
    if (cell.key == 0 || cell.born_ns == kUnsteady) continue;
    const auto piece = piece_of(cell);
    if (!piece || !space.is_clear(piece->point_m)) continue;
    cell.born_ns = kUnsteady;
    ++unsteady_;
  }
  if (next_swept_ == table_.size()) next_swept_ = 0;
}

void SurfaceMap::clear() {
  for (std::size_t i = 0; i < table_.size(); ++i) table_[i] = {};
  count_ = 0;
  frame_ = 0;
  unsteady_ = 0;
  next_swept_ = 0;
}

void SurfaceMap::move(const std::function<hal::Pose(hal::TimeNs)>& correction_at) {
  struct Piece {
    Vector3f point_m;
    Vector3f normal;  // mean: shorter than one where the cell holds a corner
    std::int32_t weight;
    hal::TimeNs born_ns;
  };
  std::vector<Piece> pieces;
  pieces.reserve(count_);
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const Cell& cell = table_[i];
    if (cell.key == 0 || cell.born_ns == kUnsteady) continue;
    const hal::RigidTransform T = hal::to_transform(correction_at(cell.born_ns));
    const Vector3f arm = rotated(T, mean_point_m(cell));
    pieces.push_back({{arm[0] + T.translation_m[0], arm[1] + T.translation_m[1], arm[2] + T.translation_m[2]},
                      rotated(T, mean_normal(cell)),
                      cell.weight,
                      cell.born_ns});
  }
  clear();
  // The older of two that meet gives the time of birth, and the order within the table does not matter.
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.born_ns != b.born_ns ? a.born_ns < b.born_ns : a.point_m < b.point_m;
  });
  for (const Piece& piece : pieces) {
    const auto place = place_of(piece.point_m);
    if (!place) {
      ++refused_;
      continue;
    }
    const std::uint64_t key = key_at(*place, piece.normal);
    Cell& cell = cell_for(key);
    if (cell.key == 0) {
      cell.key = key;
      cell.born_ns = piece.born_ns;
      ++count_;
    }
    if (cell.weight > kMostWeight) halve(cell);
    add_to(cell, *place, piece.normal, piece.weight);
  }
}

void SurfaceMap::halve(Cell& cell) {
  cell.weight /= 2;
  for (int i = 0; i < 3; ++i) {
    cell.place[i] /= 2;
    cell.normal[i] /= 2;
  }
}

const SurfaceMap::Cell* SurfaceMap::look_up(std::uint64_t key) const {
  std::size_t at = spread(key) & mask_;
  while (table_[at].key != 0) {
    if (table_[at].key == key) return &table_[at];
    at = (at + 1) & mask_;
  }
  return nullptr;
}

Vector3f SurfaceMap::mean_normal(const Cell& cell) {
  const float w = static_cast<float>(cell.weight);
  Vector3f mean;
  for (std::size_t i = 0; i < 3; ++i) mean[i] = static_cast<float>(cell.normal[i]) / (w * kNormalParts);
  return mean;
}

Vector3f SurfaceMap::mean_point_m(const Cell& cell) const {
  const float w = static_cast<float>(cell.weight);
  const CellIndex index = index_of(cell.key);
  const std::int32_t low[3] = {index.x, index.y, index.z};
  Vector3f mean_m;
  for (std::size_t i = 0; i < 3; ++i) {
    // A sum of offsets that were cut to whole parts is half a part too low.
    const float offset = (static_cast<float>(cell.place[i]) / w + 0.5F) / static_cast<float>(kPlaceParts);
    mean_m[i] = (static_cast<float>(low[i]) + offset) * options_.cell_m;
  }
  return mean_m;
}

std::optional<SurfacePiece> SurfaceMap::piece_of(const Cell& cell) const {
  if (cell.weight < kLeastWeight) return std::nullopt;
  SurfacePiece piece{{}, mean_normal(cell)};
  float length = 0.0F;
  for (const float x : piece.normal) length += x * x;
  length = std::sqrt(length);
  if (length < options_.least_coherence) return std::nullopt;
  for (float& x : piece.normal) x /= length;
  piece.point_m = mean_point_m(cell);
  return piece;
}

std::optional<SurfacePiece> SurfaceMap::find(const Vector3f& point_m, const Vector3f& normal,
                                             hal::TimeNs born_by_ns) const {
  const float per_cell = 1.0F / options_.cell_m;
  const float q[3] = {point_m[0] * per_cell, point_m[1] * per_cell, point_m[2] * per_cell};
  if (!is_inside(q)) return std::nullopt;
  CellIndex index{static_cast<std::int32_t>(std::floor(q[0])), static_cast<std::int32_t>(std::floor(q[1])),
                  static_cast<std::int32_t>(std::floor(q[2]))};
  const int facing = facing_of(normal);
  std::int32_t& along = facing < 2 ? index.x : facing < 4 ? index.y : index.z;
  std::optional<SurfacePiece> best;
  float least = 1e9F;
  const std::int32_t centre = along;
  for (int step = -1; step <= 1; ++step) {
    along = centre + step;
    const Cell* cell = look_up(key_of(index, facing));
    if (cell == nullptr || cell->born_ns > born_by_ns) continue;
    const auto piece = piece_of(*cell);
    if (!piece) continue;
    const float distance = std::abs(piece->normal[0] * (point_m[0] - piece->point_m[0]) +
                                    piece->normal[1] * (point_m[1] - piece->point_m[1]) +
                                    piece->normal[2] * (point_m[2] - piece->point_m[2]));
    if (distance < least) {
      least = distance;
      best = piece;
    }
  }
  return best;
}

}  // namespace g3d::mapper::align
