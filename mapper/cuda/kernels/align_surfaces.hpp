// SPDX-License-Identifier: Apache-2.0
// What align::SurfaceMap does with a frame's samples, for many threads at once:
//
//   place_samples   the cell of each sample, made if it is not there | the first sample of each cell
//   lead_cells      that one has the cell begin, or halves it
//   add_samples     sums
//   sweep_cells     cells that have left
//   export_cells    all that has changed, to the host
#pragma once

#include "mapper/cuda/kernels/align_match.hpp"
#include "mapper/cuda/kernels/align_samples.hpp"
#include "mapper/cuda/kernels/cast_rays.hpp"

namespace g3d::mapper::cuda {

/// The host's cells, as they lie there.
inline G3D_GPU void import_cells(const Block& block, const Memory& m, std::uint32_t first, std::uint32_t count) {
  for_tiles(block, count, [&](std::uint32_t i) {
    m.align.cells[first + i] = m.align.parcel[i];
    m.align.cell_firsts[first + i] = kNone;
  });
}

struct PlacedSample {
  align::Vector3f point_m;
  align::Vector3f normal;
};
inline G3D_GPU PlacedSample placed(const align::DepthSample& sample, const hal::RigidTransform& T) {
  return {align::transformed(T, sample.point_m), align::rotated(T, sample.normal)};
}

/// kNone: there is none, and no new ones are taken.
inline G3D_GPU std::uint32_t slot_for(const AlignMemory& a, std::uint64_t key, bool takes_new) {
  auto at = static_cast<std::uint32_t>(align::home_of(key, a.slot_mask));
  for (;;) {
    std::uint64_t stored = a.cells[at].key;
    if (stored == 0 && !takes_new) return kNone;
    if (stored == 0) stored = atomic_cas(&a.cells[at].key, std::uint64_t{0}, key);
    if (stored == 0 || stored == key) return at;
    at = (at + 1) & a.slot_mask;
  }
}

inline G3D_GPU void place_samples(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const AlignQuestion& question = *a.question;
  for_tiles(block, tiles_of(question.shape), [&](std::uint32_t i) {
    const align::DepthSample sample = a.samples[i];
    std::uint32_t slot = kNone;
    if (sample.weight > 0.0F && sample.weight >= question.rule.least_sample_weight) {
      const PlacedSample there = placed(sample, question.T_world_camera);
      align::CellPlace place;
      if (align::place_of(question.rule, there.point_m, place)) {
        slot = slot_for(a, align::key_at(place, there.normal), question.takes_new != 0);
      }
      if (slot == kNone) atomic_add(&a.state->refused, 1U);
    }
    a.sample_cell[i] = slot;
    if (slot != kNone) atomic_min(a.cell_firsts + slot, i);
  });
}

inline G3D_GPU bool is_free_at(const Memory& m, std::int32_t x, std::int32_t y, std::int32_t z) {
  const VoxelIndex index{x, y, z};
  if (!is_inside_grid(index)) return false;
  const MCode code = encode(index);
  const BlockLevels levels = CardBlocks{m}.find(code >> kBlockShift);
  const std::uint32_t stored = levels.plane != nullptr ? levels.plane[code & kPlaceMask] : levels.uniform_level;
  return state_of(stored) == State::free;
}
/// See align::SeenSpace.
inline G3D_GPU bool is_free(const Memory& m, float resolution_m, const align::Vector3f& p) {
  return is_free_at(m, cell_of(p[0] / resolution_m, 0), cell_of(p[1] / resolution_m, 0),
                    cell_of(p[2] / resolution_m, 0));
}
inline G3D_GPU bool is_clear(const Memory& m, float resolution_m, const align::Vector3f& p) {
  const std::int32_t x = cell_of(p[0] / resolution_m, 0);
  const std::int32_t y = cell_of(p[1] / resolution_m, 0);
  const std::int32_t z = cell_of(p[2] / resolution_m, 0);
#pragma GCC unroll 1
  for (int i = 0; i < 27; ++i) {
    if (!is_free_at(m, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1)) return false;
  }
  return true;
}

inline G3D_GPU void lead_cells(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const AlignQuestion& question = *a.question;
  for_tiles(block, tiles_of(question.shape), [&](std::uint32_t i) {
    const std::uint32_t slot = a.sample_cell[i];
    if (slot == kNone || a.cell_firsts[slot] != i) return;
    a.cell_firsts[slot] = kNone;
    align::SurfaceCell& cell = a.cells[slot];
    if (cell.weight == 0) {
      cell.born_ns = question.stamp_ns;
      const PlacedSample there = placed(a.samples[i], question.T_world_camera);
      if (question.looks_at_map != 0 && is_free(m, question.resolution_m, there.point_m)) {
        cell.born_ns = align::kUnsteady;
      }
    } else if (cell.weight > align::kMostCellWeight) {
      align::halve(cell);
    }
    cell.frame = question.frame;
    a.touched[atomic_add(&a.state->touched, 1U)] = slot;
  });
}

inline G3D_GPU void add_samples(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const AlignQuestion& question = *a.question;
  const auto add = [](std::int32_t& sum, std::int32_t term) {
    atomic_add(reinterpret_cast<AnyWord*>(&sum), static_cast<std::uint32_t>(term));
  };
  for_tiles(block, tiles_of(question.shape), [&](std::uint32_t i) {
    const std::uint32_t slot = a.sample_cell[i];
    if (slot == kNone) return;
    const align::DepthSample sample = a.samples[i];
    const PlacedSample there = placed(sample, question.T_world_camera);
    align::CellPlace place;
    if (!align::place_of(question.rule, there.point_m, place)) return;  // it was one
    align::SurfaceCell& cell = a.cells[slot];
    const std::int32_t weight = align::whole_weight(sample.weight);
    add(cell.weight, weight);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add(cell.place[axis], align::place_term(place, axis, weight));
      add(cell.normal[axis], align::normal_term(there.normal, axis, weight));
    }
  });
}

/// The cell in a slot, if its key's home is to be swept.
inline G3D_GPU void sweep_cell(const Memory& m, std::uint32_t slot) {
  const AlignMemory& a = m.align;
  const AlignQuestion& question = *a.question;
  align::SurfaceCell& cell = a.cells[slot];
  if (cell.key == 0 || cell.born_ns == align::kUnsteady) return;
  const auto home = static_cast<std::uint32_t>(align::home_of(cell.key, a.slot_mask));
  if (home < question.swept_first || home >= question.swept_end) return;
  align::SurfacePiece piece;
  if (!align::piece_of(question.rule, cell, piece) || !is_clear(m, question.resolution_m, piece.point_m)) return;
  cell.born_ns = align::kUnsteady;
  if (cell.frame != question.frame) a.touched[atomic_add(&a.state->touched, 1U)] = slot;
}

/// The slots of the homes, and those behind them up to the next empty one.
inline G3D_GPU void sweep_cells(const Block& block, const Memory& m) {
  const AlignMemory& a = m.align;
  const std::uint32_t first = a.question->swept_first;
  const std::uint32_t end = a.question->swept_end;
  for_tiles(block, end - first + 1, [&](std::uint32_t i) {
    if (first + i < end) {
      sweep_cell(m, first + i);
      return;
    }
    for (std::uint32_t at = end; a.cells[at & a.slot_mask].key != 0; ++at) sweep_cell(m, at & a.slot_mask);
  });
}

inline G3D_GPU void export_cells(const Block& block, const Memory& m, std::uint32_t room) {
  const AlignMemory& a = m.align;
  for_tiles(block, least(a.state->touched, room), [&](std::uint32_t i) { a.parcel[i] = a.cells[a.touched[i]]; });
}

}  // namespace g3d::mapper::cuda
