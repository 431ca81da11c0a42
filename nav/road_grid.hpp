// SPDX-License-Identifier: Apache-2.0
// Where the body can go, three or so map cells to a step, for quick estimates of travel: a road cell is open if the
// body's centre may stand anywhere in it. A step leads to a neighbour only if the planner could take it as well: from
// map cell to map cell, sharing a side. Otherwise a gap that is a little too narrow, or a line of unknown cells, would
// look like a way, and every goal behind it would fail. Where what can be stood on in a road cell is in several pieces,
// the largest counts. A planner finds the exact way later. One thread; sized by reset().
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "nav/cell_grid.hpp"
#include "nav/work_budget.hpp"

namespace g3d::nav {

/// Travel from one road cell to all others.
struct TravelField {
  static constexpr std::int32_t kNever = std::numeric_limits<std::int32_t>::max();
  std::vector<std::int32_t> distance;    ///< in tenths of a road cell, kNever: not connected
  std::vector<std::uint32_t> came_from;  ///< the road cell before
  std::vector<std::uint32_t> leaves_by;  ///< a road cell about half a metre from the start on the way there
  std::vector<std::uint32_t> reached;    ///< in order of distance
  std::vector<std::uint32_t> touched;    ///< all that were given a distance; after a limited search some have none now
};

class RoadGrid {
 public:
  void reset(const CellGrid<std::uint8_t>& cost, double body_radius_m);
  void update(const CellGrid<std::uint8_t>& cost, std::span<const std::uint32_t> changed);

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] std::size_t size() const { return is_open_.size(); }
  /// Map cells along the side of a road cell.
  [[nodiscard]] int stride() const { return stride_; }
  /// The body's middle may be there, and the road cell's way leads there.
  [[nodiscard]] bool may_stand(const Cell& c) const {
    return may_stand_[static_cast<std::size_t>(c.y) * static_cast<std::size_t>(cell_columns_) +
                      static_cast<std::size_t>(c.x)] == 2;
  }
  [[nodiscard]] double step_m() const { return step_m_; }
  [[nodiscard]] bool is_open(std::size_t road) const { return is_open_[road] != 0; }
  [[nodiscard]] std::uint32_t road_of(Cell c) const {
    return static_cast<std::uint32_t>(c.y / stride_ * columns_ + c.x / stride_);
  }
  /// The map cell in a road cell where the body stands best (lowest cost, then most central); false if it is closed.
  [[nodiscard]] bool best_cell(const CellGrid<std::uint8_t>& cost, std::size_t road, Cell& out) const;

  void size_field(TravelField& field) const;
  /// Dijkstra from `from`, up to `limit` tenths. A robot that stands on closed ground, or is hemmed in where it could
  /// hardly turn, gets out to the nearest open road cell beyond, if there is one near. Reuses the field's memory.
  void travel(std::uint32_t from, std::int32_t limit, TravelField& out);
  /// The same in pieces: go_on() until it says true. One search at a time; a new begin drops the one before.
  void begin_travel(std::uint32_t from, std::int32_t limit, TravelField& out);
  [[nodiscard]] bool go_on(TravelField& out, WorkBudget& budget);
  /// Headings at the start and at the end of the way to `to`.
  [[nodiscard]] double leave_heading(const TravelField& field, std::uint32_t from, std::uint32_t to) const;
  [[nodiscard]] double arrive_heading(const TravelField& field, std::uint32_t to) const;

 private:
  void may_now_stand(Cell c, bool may);
  void find_largest_piece(std::uint32_t road);
  void note_neighbours(const std::vector<std::uint32_t>& of, std::vector<std::uint32_t>& all);
  [[nodiscard]] bool are_joined(std::uint32_t road, int straight) const;
  [[nodiscard]] std::uint8_t steps_from(std::uint32_t road) const;
  void join_changed();
  [[nodiscard]] std::int32_t way_out(std::uint32_t from, const TravelField& field, std::uint32_t& exit) const;
  void seed(std::uint32_t road, std::int32_t tenths, TravelField& out);
  [[nodiscard]] bool spread(TravelField& out, WorkBudget& budget);
  [[nodiscard]] double bearing(std::uint32_t from, std::uint32_t to) const;

  int columns_ = 0;
  int rows_ = 0;
  int stride_ = 1;
  double step_m_ = 0.05;
  int cell_columns_ = 0;  ///< of the map
  int cell_rows_ = 0;
  std::vector<std::uint8_t> may_stand_;  ///< per map cell: 0 no, 1 yes, 2 yes and in its road cell's largest piece
  std::vector<std::uint8_t> is_open_;    ///< per road cell
  std::vector<std::uint8_t> joined_;     ///< bits of the straight directions in which a neighbour can be entered
  std::vector<std::uint8_t> steps_;      ///< bits of all directions
  std::vector<std::uint32_t> changed_;   ///< road cells since the last join_changed()
  std::vector<std::uint32_t> around_;    ///< those and their neighbours
  std::vector<std::uint32_t> farther_;   ///< and theirs
  std::vector<std::uint8_t> is_noted_;
  std::vector<std::uint32_t> piece_;  ///< map cells
  std::vector<std::uint32_t> largest_;
  // Of the search that is under way.
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::uint32_t from_ = 0;
  std::int32_t limit_ = 0;
  std::int32_t bucket_distance_ = 0;
  std::size_t bucket_next_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace g3d::nav
