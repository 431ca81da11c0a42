// SPDX-License-Identifier: Apache-2.0
// What a card needs to align frames: the surfaces, one frame's samples, the question and what comes of it. Beside the
// map in the same memory (see memory.hpp).
#pragma once

#include <cstddef>
#include <cstdint>

#include "mapper/align/pose_fit.hpp"

namespace g3d::mapper::cuda {

inline constexpr int kMostFitSteps = 15;

/// From the host. The first part is for the fit, the second for what is added after it.
struct AlignQuestion {
  align::SampleShape shape;
  align::SurfaceRule rule;
  align::FitQuestion fit;

  hal::RigidTransform T_world_camera;
  std::int64_t stamp_ns;
  std::uint32_t frame;         ///< number, as cells note it
  std::uint32_t takes_new;     ///< 0: the table is full
  std::uint32_t looks_at_map;  ///< what came into free space, or has left, is not to be found again
  float resolution_m;          ///< of the map
  std::uint32_t swept_first;   ///< homes whose cells are looked at
  std::uint32_t swept_end;
};

/// To the host.
struct AlignState {
  std::uint32_t chosen;                      ///< samples
  std::uint32_t steps;                       ///< sums[steps] are the last ones
  std::uint32_t ended;                       ///< nothing moves any more
  std::uint32_t touched;                     ///< cells that the frame has changed
  std::uint32_t refused;                     ///< samples for which there was no cell
  std::uint32_t arrived[kMostFitSteps + 1];  ///< blocks of threads, in each step
  hal::RigidTransform T_world_camera;        ///< of the pose
  hal::Pose pose;                            ///< as of the last step
  align::NormalSums sums[kMostFitSteps + 1];
};

/// What host and card tell one another.
struct Alignment {
  AlignQuestion* question;
  AlignState* state;
  align::SurfaceCell* cells;
  std::uint32_t cell_room;
};

struct AlignMemory {
  AlignQuestion* question;
  AlignState* state;
  float* inverse_depth;         ///< of tiles
  align::DepthSample* samples;  ///< of tiles; weight 0: none
  std::uint32_t* sample_cube;   ///< place in the table of cubes, kNone
  std::uint32_t* sample_cell;   ///< slot, kNone
  std::uint32_t* chunk_counts;  ///< chosen among each kAlignChunk tiles
  align::DepthSample* chosen;
  std::uint32_t cube_mask;
  std::uint64_t* cube_keys;    ///< 0: empty
  std::uint32_t* cube_firsts;  ///< first tile that lies in it
  std::uint32_t slot_mask;
  align::SurfaceCell* cells;
  std::uint32_t* cell_firsts;  ///< by slot: first tile that lies in it, kNone between frames
  std::uint32_t* touched;      ///< slots
  align::SurfaceCell* parcel;  ///< on their way
};

inline constexpr std::uint32_t kAlignChunk = 256;
inline constexpr std::uint32_t kMostChosen = 4096;

/// Tiles of an image at most; see DepthSamples.
[[nodiscard]] constexpr std::uint32_t tiles_of(std::uint32_t width_px, std::uint32_t height_px) {
  const std::uint32_t tile = width_px / align::kTilesAcross < 1 ? 1 : width_px / align::kTilesAcross;
  return (width_px / tile) * (height_px / tile);
}
/// Cells that one frame may change: one for each tile, and those that have left.
[[nodiscard]] constexpr std::uint32_t touched_room(std::uint32_t tiles, std::uint32_t slots) {
  return slots == 0 ? 0 : tiles + slots / 16;
}
[[nodiscard]] constexpr std::uint32_t cube_slots(std::uint32_t tiles) {
  std::uint32_t size = 32;
  while (size < 2 * tiles) size *= 2;
  return size;
}

/// `slots`: of the table of surfaces, a power of two; 0: frames are not aligned here.
template <typename Pointers, typename Take>
void place_alignment(Pointers& a, std::uint32_t width_px, std::uint32_t height_px, std::uint32_t slots,
                     const Take& take) {
  const std::uint32_t tiles = slots == 0 ? 0 : tiles_of(width_px, height_px);
  take(a.question, 1);
  take(a.state, 1);
  take(a.inverse_depth, tiles);
  take(a.samples, tiles);
  take(a.sample_cube, tiles);
  take(a.sample_cell, tiles);
  take(a.chunk_counts, tiles / kAlignChunk + 1);
  take(a.chosen, slots == 0 ? 0 : kMostChosen);
  a.cube_mask = cube_slots(tiles) - 1;
  take(a.cube_keys, slots == 0 ? 0 : cube_slots(tiles));
  take(a.cube_firsts, slots == 0 ? 0 : cube_slots(tiles));
  a.slot_mask = slots - 1;
  take(a.cells, slots);
  take(a.cell_firsts, slots);
  take(a.touched, touched_room(tiles, slots));
  take(a.parcel, touched_room(tiles, slots));
}

}  // namespace g3d::mapper::cuda
