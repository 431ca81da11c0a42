// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/surface_map.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <vector>

namespace g3d::mapper::align {

SurfaceMap::SurfaceMap(const SurfaceOptions& options)
    : options_(options), mask_(options.slots - 1), table_(options.slots) {
  assert((options.slots & mask_) == 0);
  table_.touch(table_.size_bytes());
}

SurfaceCell& SurfaceMap::cell_for(std::uint64_t key) {
  std::size_t at = home_of(key, mask_);
  while (table_[at].key != 0 && table_[at].key != key) at = (at + 1) & mask_;
  return table_[at];
}

void SurfaceMap::add_to(SurfaceCell& cell, const CellPlace& place, const Vector3f& normal, std::int32_t weight) {
  cell.weight += weight;
  for (std::size_t i = 0; i < 3; ++i) {
    cell.place[i] += place_term(place, i, weight);
    cell.normal[i] += normal_term(normal, i, weight);
  }
}

void SurfaceMap::add(std::span<const DepthSample> samples, const hal::RigidTransform& T, hal::TimeNs stamp_ns,
                     const SeenSpace* space) {
  ++frame_;
  const bool takes_new = takes_new_cells();
  for (const DepthSample& sample : samples) {
    if (sample.weight < options_.rule.least_sample_weight) continue;
    const Vector3f point_m = transformed(T, sample.point_m);
    const Vector3f n = rotated(T, sample.normal);
    CellPlace place;
    if (!place_of(options_.rule, point_m, place)) {
      ++refused_;
      continue;
    }
    const std::uint64_t key = key_at(place, n);
    SurfaceCell& cell = cell_for(key);
    if (cell.key == 0) {
      if (!takes_new || count_ + 1 == table_.size()) {
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
      if (cell.weight > kMostCellWeight) halve(cell);
    }
    add_to(cell, place, n, whole_weight(sample.weight));
  }
}

void SurfaceMap::forget_if_gone(SurfaceCell& cell, const SeenSpace& space) {
  SurfacePiece piece;
  if (cell.born_ns == kUnsteady || !piece_of(options_.rule, cell, piece) || !space.is_clear(piece.point_m)) return;
  cell.born_ns = kUnsteady;
  ++unsteady_;
}

// By their keys' homes, since where a cell came to lie depends on who came first.
void SurfaceMap::forget_gone(const SeenSpace& space) {
  const std::size_t end = next_swept_ + table_.size() / kSweeps;
  for (std::size_t i = next_swept_; i < end || table_[i & mask_].key != 0; ++i) {
    SurfaceCell& cell = table_[i & mask_];
    if (cell.key == 0) continue;
    const std::size_t home = home_of(cell.key, mask_);
    if (home >= next_swept_ && home < end) forget_if_gone(cell, space);
  }
  next_swept_ = end == table_.size() ? 0 : end;
}

bool SurfaceMap::is_poor(const SurfaceCell& cell) const {
  constexpr std::uint32_t kLately_frames = 100;
  constexpr std::int32_t kPoorWeight = 16;
  if (frame_ - cell.frame <= kLately_frames) return false;
  SurfacePiece piece;
  return cell.born_ns == kUnsteady || cell.weight < kPoorWeight || !piece_of(options_.rule, cell, piece);
}

std::size_t SurfaceMap::make_room() {
  const std::size_t before = count_;
  if (count_ * 5 < table_.size() * 3) return 0;
  // How many good cells were seen last in each part of the time so far.
  constexpr std::uint64_t kParts = 1024;
  std::array<std::size_t, kParts> seen_last{};
  const auto part_of = [&](std::uint32_t frame) { return kParts * frame / (std::uint64_t{frame_} + 1); };
  for (const SurfaceCell& cell : table()) {
    if (cell.key != 0 && !is_poor(cell)) ++seen_last[part_of(cell.frame)];
  }
  std::uint64_t oldest = kParts;
  for (std::size_t kept = 0; oldest > 0; --oldest) {
    kept += seen_last[oldest - 1];
    if (oldest < kParts && kept * 5 > table_.size() * 2) break;
  }
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const auto goes = [&](const SurfaceCell& cell) {
      return cell.key != 0 && (is_poor(cell) || part_of(cell.frame) < oldest);
    };
    while (goes(table_[i])) erase(i);
  }
  return before - count_;
}

// Cells behind it move up, so that every key is found from its home on without a gap (Knuth, 6.4, algorithm R).
void SurfaceMap::erase(std::size_t slot) {
  unsteady_ -= table_[slot].born_ns == kUnsteady ? 1 : 0;
  --count_;
  for (std::size_t at = (slot + 1) & mask_; table_[at].key != 0; at = (at + 1) & mask_) {
    const std::size_t home = home_of(table_[at].key, mask_);
    if (((at - home) & mask_) < ((at - slot) & mask_)) continue;
    table_[slot] = table_[at];
    slot = at;
  }
  table_[slot] = {};
}

bool SurfaceMap::take(std::span<const SurfaceCell> changed, std::uint64_t refused, bool was_swept) {
  const std::uint32_t frame = next_frame();
  std::size_t unknown = 0;
  // Each lies somewhere else in a large table: the processor may as well wait for many of them at once.
  for (const SurfaceCell& cell : changed) __builtin_prefetch(&table_[home_of(cell.key, mask_)], 1);
  for (const SurfaceCell& cell : changed) {
    if (!is_sound(cell) || cell.frame > frame) return false;
    unknown += look_up(cell.key) == nullptr ? 1 : 0;
  }
  if (unknown > 0 && (!takes_new_cells() || count_ + unknown >= table_.size())) return false;
  for (const SurfaceCell& cell : changed) {
    SurfaceCell& own = cell_for(cell.key);
    count_ += own.key == 0 ? 1 : 0;
    const bool was_steady = own.key == 0 || own.born_ns != kUnsteady;
    unsteady_ += was_steady && cell.born_ns == kUnsteady ? 1 : 0;
    own = cell;
  }
  frame_ = frame;
  refused_ += refused;
  if (was_swept) next_swept_ = next_swept().end == table_.size() ? 0 : next_swept().end;
  return true;
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
    const SurfaceCell& cell = table_[i];
    if (cell.key == 0 || cell.born_ns == kUnsteady) continue;
    const hal::RigidTransform T = hal::to_transform(correction_at(cell.born_ns));
    pieces.push_back(
        {transformed(T, mean_point_m(options_.rule, cell)), rotated(T, mean_normal(cell)), cell.weight, cell.born_ns});
  }
  clear();
  // The older of two that meet gives the time of birth, and the order within the table does not matter.
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
    return a.born_ns != b.born_ns ? a.born_ns < b.born_ns : a.point_m < b.point_m;
  });
  for (const Piece& piece : pieces) {
    CellPlace place;
    if (!place_of(options_.rule, piece.point_m, place)) {
      ++refused_;
      continue;
    }
    const std::uint64_t key = key_at(place, piece.normal);
    SurfaceCell& cell = cell_for(key);
    if (cell.key == 0) {
      cell.key = key;
      cell.born_ns = piece.born_ns;
      ++count_;
    }
    if (cell.weight > kMostCellWeight) halve(cell);
    add_to(cell, place, piece.normal, piece.weight);
  }
}

const SurfaceCell* SurfaceMap::look_up(std::uint64_t key) const {
  std::size_t at = home_of(key, mask_);
  while (table_[at].key != 0) {
    if (table_[at].key == key) return &table_[at];
    at = (at + 1) & mask_;
  }
  return nullptr;
}

std::optional<SurfacePiece> SurfaceMap::find(const Vector3f& point_m, const Vector3f& normal,
                                             hal::TimeNs born_by_ns) const {
  SurfacePiece piece;
  const auto looks = [&](std::uint64_t key) { return look_up(key); };
  if (!nearest_piece(options_.rule, point_m, normal, born_by_ns, looks, piece)) return std::nullopt;
  return piece;
}

}  // namespace g3d::mapper::align
