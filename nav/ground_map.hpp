// SPDX-License-Identifier: Apache-2.0
// The floor as the robot's body sees it, kept up to date from the blocks that a frame changed. One column of voxels:
//
//   body_height ──┬── band: something here stops the robot                 occupied
//                 │     only seen through, floor not (yet) in view         free, but see is_floor_seen()
//        step ────┼── floor: something here carries it                     free
//           0 ════│════════════════════════════════════════════════
//       -drop ────┼── seen through although no floor was seen above: a     occupied (a drop-off), and so are cells
//                 │   staircase                                            nearby whose floor nobody has seen
//
// What a camera half a metre above the floor sees: the floor from 1.1 m on, walls and furniture from 0.8 m on; nearer
// than that only that the air at camera height is clear. So a cell is free where its floor was seen, and also where
// the air was; the latter is a presumption, to be driven slowly (a low box may hide there). It does not hold where one
// has looked through so close above the ground that the floor ought to have been seen, and no floor is near: rays
// without a reading tunnel through walls that are too near to be measured.
// One voxel hit a single time, with nothing around it, is a speckle: not an obstacle until it is hit again.
// Thread: the voxel map's writer, since update() reads it without locks. After construction nothing allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mapper/pool.hpp"
#include "mapper/voxel_map.hpp"
#include "nav/cell_grid.hpp"
#include "nav/column_evidence.hpp"
#include "nav/ground_layers.hpp"

namespace g3d::nav {

struct GroundMapConfig {
  double centre_x_m = 0.0;  ///< the start, world frame
  double centre_y_m = 0.0;
  double side_m = 102.4;  ///< of the square around it; rounded up to whole blocks
  GroundHeights heights;
  double margin_m = 0.3;  ///< about cells whose floor was not seen, neighbours within this distance have a say
  std::uint8_t speckle_level = 20;     ///< an occupied voxel up to this level was hit once (16 + MapperConfig's hit)
  std::uint32_t max_slots = 1U << 18;  ///< of the voxel map (MapCapacity::blocks): whose loss is noticed
};

class GroundMap {
 public:
  GroundMap(const mapper::Grid& grid, const GroundMapConfig& config);

  /// Takes over what changed. A slot that is empty now has the block forgotten that it was last reported with. Blocks
  /// that leave without being reported (paged out, their slots perhaps taken by others) stay known here as they were.
  void update(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots);
  /// The same from what a card has read, by column_tables(): before the voxel map is up to date. When it is,
  /// note_slots() must be told, so that the loss of these blocks is noticed as after update().
  void update(const mapper::ChangedColumns& columns);
  void note_slots(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots);
  [[nodiscard]] const mapper::ColumnTables& column_tables() const { return reader_.tables(); }
  /// Everything anew. Marks stay.
  void rebuild(const mapper::VoxelMap& map);

  /// The robot stands here, so there is floor and nothing else, until an obstacle is measured there.
  void mark_free_disc(double x_m, double y_m, double radius_m);
  /// The bumper met what the camera did not see. Where the floor had been seen the camera is not believed any more
  /// (glass, black things); elsewhere the mark goes when the floor comes into view.
  void mark_contact(double x_m, double y_m, double radius_m);
  /// A step that voxels are too coarse for, or none any more.
  void mark_step(Cell c, bool is_step);
  /// Drops all marks, and what is known to have come later: the map has moved.
  void forget_marks();
  /// Drops all contact marks: a last resort, for whoever finds no way any more.
  void forget_contacts();

  [[nodiscard]] const CellGrid<CellState>& states() const { return states_; }
  /// Indices of the cells whose state the last update() or rebuild() changed, and marks since the one before it.
  /// May name a cell twice, or one that has changed back. Valid until the next call.
  [[nodiscard]] std::span<const std::uint32_t> changed_cells() const { return changed_; }

  // May lie outside: then false.
  [[nodiscard]] bool is_floor_seen(Cell c) const { return has(c, kFloorSeen); }
  [[nodiscard]] bool is_drop(Cell c) const { return has(c, kDropSeen); }
  [[nodiscard]] bool is_contact(Cell c) const { return has(c, kContact); }
  /// What is occupied here came (again) after the floor had been seen free.
  [[nodiscard]] bool came_later(Cell c) const { return has(c, kCameLater); }
  [[nodiscard]] const GroundLayers& layers() const { return layers_; }
  [[nodiscard]] double resolution_m() const { return states_.resolution_m; }

 private:
  // Of a cell: the low bits come from the voxels (column_evidence.hpp), the others from marks.
  using Marked = std::uint16_t;
  static constexpr Marked kFromVoxels = kFloorSeen | kAirSeen | kLowSeen | kDropSeen | kHitOnce | kObstacle;
  static constexpr Marked kStart = 256, kContact = 512, kDistrusted = 1024, kCameLater = 2048, kStep = 4096;

  [[nodiscard]] bool has(Cell c, Marked bit) const {
    return states_.contains(c) && (evidence_[states_.index(c)] & bit) != 0;
  }
  void forget_published_changes();
  bool note_block(mapper::BlockKey key);
  void sum_up_noted();
  void read_noted_blocks(const mapper::VoxelMap& map);
  void read_block(const mapper::VoxelMap& map, std::uint32_t place);
  void sum_up_stack(std::uint32_t stack);
  void set_evidence(Cell c, Evidence from_voxels);
  void spread(Cell c, std::vector<std::uint16_t>& counts, int step);
  void refresh(Cell c);
  void refresh_around(Cell c);
  [[nodiscard]] CellState judge(Cell c) const;
  [[nodiscard]] bool has_hit_neighbour(Cell c) const;
  template <typename Visit>
  void for_disc(double x_m, double y_m, double radius_m, Visit visit);

  GroundMapConfig config_;
  GroundLayers layers_;
  ColumnReader reader_;
  int side_blocks_;
  std::int32_t first_block_x_;  ///< block coordinates (voxel index / 8) of the lower left corner
  std::int32_t first_block_y_;
  CellGrid<CellState> states_;
  int block_layers_;
  mapper::ReservedArray<Evidence> block_evidence_;  ///< what each block said last: [stack][layer][cell]
  std::vector<Marked> evidence_;
  std::vector<std::uint16_t> drops_near_;   ///< drop cells within margin_m
  std::vector<std::uint16_t> floors_near_;  ///< cells within margin_m whose floor was seen
  std::vector<Cell> margin_offsets_;
  std::vector<std::uint32_t> changed_;
  std::size_t published_ = 0;               ///< how many of changed_ the last update() has shown
  std::vector<mapper::BlockKey> slot_key_;  ///< whose block a slot held when it was last reported
  std::vector<std::uint32_t> places_;       ///< blocks to read again: stack * block_layers_ + layer
};

}  // namespace g3d::nav
