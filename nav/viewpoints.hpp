// SPDX-License-Identifier: Apache-2.0
// Places worth looking from: about one per 30 cm of open ground within sight of a frontier, each with what it would
// show in every direction. Rays are cast anew only where the map within their reach has changed. One thread; sized by
// reset().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nav/frontier.hpp"
#include "nav/road_grid.hpp"
#include "nav/view_gain.hpp"
#include "nav/work_budget.hpp"

namespace g3d::nav {

struct Place {
  Cell cell;                 ///< of the map; the body may stand in its middle
  std::uint32_t road = 0;    ///< the road cell that holds it
  float total_cells = 0.0F;  ///< of all directions
  PanoramaGain gain;
};

class Viewpoints {
 public:
  static constexpr std::size_t kMaxPlaces = 8192;

  void reset(const CellGrid<CellState>& ground, const RoadGrid& roads);
  /// Cells whose ground or cost changed.
  void note_changes(std::span<const std::uint32_t> changed);
  /// Brings places that `from_robot` reaches up to date, nearest first, at most `max_casts` of them; true if none is
  /// left over.
  bool refresh(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
               const TravelField& from_robot, const FrontierMap& frontiers, const ViewGain& camera, int max_casts);
  /// The same in pieces: go_on() until it says true; then is_complete() tells what refresh() returns.
  void begin_refresh(const FrontierMap& frontiers, const ViewGain& camera, double resolution_m, int max_casts);
  [[nodiscard]] bool go_on(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                           const TravelField& from_robot, const ViewGain& camera, WorkBudget& budget);
  [[nodiscard]] bool is_complete() const { return is_complete_; }

  /// Until told otherwise, refreshing also looks from cells that frontiers see, where their place shows nothing from
  /// its cheapest one: through a slit there may be one cell alone that looks in.
  void look_closer(bool closer) {
    is_closer_ = closer;
    marked_directions_ = 0;
  }

  /// Those that would show something and can be reached, nearest first; indices for place().
  [[nodiscard]] std::span<const std::uint32_t> useful() const { return useful_; }
  [[nodiscard]] const Place& place(std::uint32_t slot) const { return slots_[slot]; }

 private:
  static constexpr std::uint32_t kNoSlot = 0xFFFFFFFF;

  void mark_sight_of_frontiers(const FrontierMap& frontiers, int reach_tiles);
  [[nodiscard]] std::size_t tile_at(int tile_x, int tile_y) const {
    return static_cast<std::size_t>(tile_y) * static_cast<std::size_t>(tile_columns_) +
           static_cast<std::size_t>(tile_x);
  }
  [[nodiscard]] std::uint32_t newest_change(int tile_x, int tile_y) const;
  [[nodiscard]] bool is_outdated(std::size_t place, int tile_x, int tile_y);
  void cast(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
            const TravelField& from_robot, const ViewGain& camera, std::size_t place);
  /// From all cells of a place; returns how many looks that took.
  int cast_closer(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const RoadGrid& roads,
                  const TravelField& from_robot, const ViewGain& camera, std::size_t place);
  /// In the next direction.
  void mark_seen_by_frontiers(const CellGrid<CellState>& ground, const ViewModel& camera, WorkBudget& budget);
  void keep(std::size_t place, const Place& found);

  int columns_ = 0;  ///< of the map
  int tile_cells_ = 1;
  int tile_columns_ = 0;
  int tile_rows_ = 0;
  int place_columns_ = 0;
  std::uint32_t round_ = 0;  ///< counts note_changes()
  // Of the refresh that is under way.
  std::uint32_t pass_ = 0;
  int reach_tiles_ = 0;
  int casts_left_ = 0;
  std::size_t next_ = 0;  ///< of the road cells that the robot reaches
  bool is_complete_ = true;
  std::vector<std::uint32_t> changed_in_;    ///< per tile: round of its last change
  std::vector<std::uint32_t> newest_near_;   ///< per tile: newest of the tiles within sight,
  std::vector<std::uint32_t> newest_round_;  ///< as of this round
  std::vector<std::uint8_t> near_frontier_;  ///< per tile
  std::vector<std::uint32_t> cast_in_;       ///< per place: round of its last cast, 0: never
  std::vector<std::uint32_t> closer_in_;     ///< the same from all its cells
  bool is_closer_ = false;
  // For looking closer
  int marked_directions_ = 0;
  std::vector<std::uint32_t> frontier_cells_;  ///< some, evenly
  std::vector<std::uint8_t> seen_by_them_;     ///< per map cell
  std::vector<std::uint32_t> visited_in_;      ///< per place: pass
  std::vector<std::uint32_t> slot_of_;
  std::vector<Place> slots_;
  std::vector<std::uint32_t> free_slots_;
  std::vector<std::uint32_t> useful_;
};

}  // namespace g3d::nav
