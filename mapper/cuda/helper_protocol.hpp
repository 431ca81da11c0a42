// SPDX-License-Identifier: Apache-2.0
// What the program and its helper process share: one memory file, and two counters in it that either waits for. The
// helper alone loads the driver: a static executable cannot, and what takes the driver down takes the helper down, not
// the robot. Numbers that come from the helper are checked like any others from outside.
#pragma once

#include <cstddef>
#include <cstdint>

#include "mapper/cuda/memory.hpp"

namespace g3d::mapper::cuda {

inline constexpr std::uint32_t kProtocolVersion = 4;
inline constexpr int kHelperFile = 3;  ///< file descriptor of the shared memory in the helper
inline constexpr int kHelperLine = 4;  ///< one end of a socket pair; low, so that a dying process closes it first
inline constexpr int kStages = 9;

enum class HelperState : std::uint32_t { starting, ready, failed };

enum class HelperCommand : std::uint32_t {
  import_blocks,
  run_frame,         ///< until the classes are there; the first parcels are under way then
  run_frame_timed,   ///< copies first; then in stage_us how long the launches took, the classes, the first parcels
  run_stages_timed,  ///< launch by launch, with the time of each: input copy, then launches.hpp's
  send_blocks,       ///< from number `count` on
  set_columns,       ///< as column_tables says
  read_columns,      ///< from number `count` on; time as for rays
  cast_rays,         ///< `count` of them; stage_us[0] is the time of the launch, as for looks
  count_looks,       ///< `count` of them
  spread_grid,       ///< time as for rays
  import_cells,      ///< `count` of them, from slot `first` on
  fit_frame,         ///< as soon as `coloured` says that question and depths are there; time as for rays
  add_samples,       ///< time as for rays
  hang,              ///< for tests: never answers
  end,               ///< ends by itself, for tools that want to look at what it leaves behind
};

/// At the beginning of the shared memory. Written by the program, but where it says otherwise.
struct HelperControl {
  std::uint32_t version;
  std::uint32_t state;     ///< HelperState; by the helper
  std::uint32_t asked;     ///< counts commands
  std::uint32_t answered;  ///< counts them as well; by the helper
  std::uint32_t command;
  std::uint32_t count;  ///< parcels to import, first changed block to send, or questions
  std::uint32_t ok;     ///< by the helper
  std::uint32_t room;   ///< parcels in one go
  std::uint32_t class_room;
  std::uint32_t first;              ///< slot
  std::uint32_t coloured;           ///< number of the command whose colours (or depths) are there
  std::uint32_t update_warps;       ///< 1 or 4 for a block of the map, 0: as the helper likes
  std::uint32_t wanted_processors;  ///< multiprocessors that kernels may use; 0: all
  MemorySizes sizes;
  FrameCounters counters;  ///< by the card
  ColumnTables column_tables;
  LookModel look_model;           ///< of the questions; for rays its resolution alone counts
  std::uint32_t awake_tiles;      ///< of a grid; by the card
  std::uint32_t refused_imports;  ///< as of the last question; by the card
  // Offsets in bytes from here
  std::uint64_t program;  ///< PTX, zero-terminated
  std::uint64_t input;    ///< FrameInput, depth, rgb as Memory has them
  std::uint64_t input_bytes;
  std::uint64_t sensor;  ///< column_slope, row_slope, mask as Memory has them
  std::uint64_t sensor_bytes;
  std::uint64_t column_keys;
  std::uint64_t column_cells;
  std::uint64_t spread;
  std::uint64_t grid_costs;
  std::uint64_t grid_distances;
  std::uint64_t rays;
  std::uint64_t ray_hits;
  std::uint64_t looks;
  std::uint64_t align_question;
  std::uint64_t align_state;
  std::uint64_t align_cells;
  std::uint64_t class_heads;
  std::uint64_t class_planes;
  std::uint64_t heads;
  std::uint64_t planes;
  std::uint64_t bricks;
  std::uint64_t all_bytes;
  // By the helper
  float stage_us[kStages];
  std::uint64_t card_bytes;      ///< that it took of the card's memory
  std::uint32_t processors;      ///< multiprocessors that kernels may use
  std::uint32_t copies_parcels;  ///< 1: the card cannot reach host memory, so parcels are copied
  char card[96];
  char problem[256];  ///< why it failed
  char note[160];     ///< why it is not quite what was wanted
};

/// Lays out everything behind the control block; returns the number of bytes in all.
[[nodiscard]] inline std::uint64_t lay_out(HelperControl& control, std::size_t program_bytes) {
  Memory m{};
  place(m, control.sizes, 0);
  const auto offset = [](const auto* p) { return static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(p)); };
  std::uint64_t next = aligned(sizeof(HelperControl));
  const auto take = [&next](std::uint64_t bytes) {
    const std::uint64_t at = next;
    next += (bytes + 4095) / 4096 * 4096;
    return at;
  };
  next = (next + 4095) / 4096 * 4096;
  control.program = take(program_bytes + 1);
  control.input_bytes = offset(m.column_slope);
  control.input = take(control.input_bytes);
  control.sensor_bytes = offset(m.ends[0]) - offset(m.column_slope);
  control.sensor = take(control.sensor_bytes);
  control.column_keys = take(std::uint64_t{control.sizes.columns} * sizeof(std::uint64_t));
  control.column_cells = take(std::uint64_t{control.sizes.columns} * kBlockSide_cells * kBlockSide_cells);
  control.spread = take(sizeof(GridSpread));
  control.grid_costs = take(control.sizes.grid_cells);
  control.grid_distances = take(std::uint64_t{control.sizes.grid_cells} * sizeof(std::uint32_t));
  control.rays = take(std::uint64_t{control.sizes.rays} * sizeof(BulkRay));
  control.ray_hits = take(std::uint64_t{control.sizes.rays} * sizeof(BulkHit));
  control.looks = take(std::uint64_t{control.sizes.looks} * sizeof(Look));
  const std::uint32_t tiles = tiles_of(control.sizes.width_px, control.sizes.height_px);
  control.align_question = take(sizeof(AlignQuestion));
  control.align_state = take(sizeof(AlignState));
  control.align_cells =
      take(std::uint64_t{touched_room(tiles, control.sizes.surface_slots)} * sizeof(align::SurfaceCell));
  control.class_heads = take(std::uint64_t{control.class_room} * sizeof(ClassHead));
  control.class_planes = take(std::uint64_t{control.class_room} * sizeof(ClassPlane));
  control.heads = take(std::uint64_t{control.room} * sizeof(ParcelHead));
  control.planes = take(std::uint64_t{control.room} * sizeof(ParcelPlane));
  control.bricks = take(std::uint64_t{control.room} * kBricks * sizeof(ParcelBrick));
  control.all_bytes = next;
  return next;
}

}  // namespace g3d::mapper::cuda
