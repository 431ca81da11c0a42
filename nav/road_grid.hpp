// SPDX-License-Identifier: Apache-2.0
// Where the body can go, three or so map cells to a step, for quick estimates of travel: a road cell is open if the
// body's centre may stand anywhere in it. It is at most 0.42 of the body's width across, so that no two open neighbours
// lie on opposite sides of a wall. A planner finds the exact way later. One thread; sized by reset().
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
  [[nodiscard]] std::size_t size() const { return standing_.size(); }
  /// Map cells along the side of a road cell.
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] double step_m() const { return step_m_; }
  [[nodiscard]] bool is_open(std::size_t road) const { return standing_[road] != 0; }
  [[nodiscard]] std::uint32_t road_of(Cell c) const {
    return static_cast<std::uint32_t>(c.y / stride_ * columns_ + c.x / stride_);
  }
  /// The map cell in a road cell where the body stands best (lowest cost, then most central); false if it is closed.
  [[nodiscard]] bool best_cell(const CellGrid<std::uint8_t>& cost, std::size_t road, Cell& out) const;

  void size_field(TravelField& field) const;
  /// Dijkstra from `from`, up to `limit` tenths. A robot that stands too near to something, on closed ground, leaves it
  /// to the nearest open road cell. Reuses the field's memory.
  void travel(std::uint32_t from, std::int32_t limit, TravelField& out);
  /// The same in pieces: go_on() until it says true. One search at a time; a new begin drops the one before.
  void begin_travel(std::uint32_t from, std::int32_t limit, TravelField& out);
  [[nodiscard]] bool go_on(TravelField& out, WorkBudget& budget);
  /// Headings at the start and at the end of the way to `to`.
  [[nodiscard]] double leave_heading(const TravelField& field, std::uint32_t from, std::uint32_t to) const;
  [[nodiscard]] double arrive_heading(const TravelField& field, std::uint32_t to) const;

 private:
  [[nodiscard]] std::int32_t way_out(std::uint32_t from, std::uint32_t& exit) const;
  [[nodiscard]] double bearing(std::uint32_t from, std::uint32_t to) const;

  int columns_ = 0;
  int rows_ = 0;
  int stride_ = 1;
  double step_m_ = 0.05;
  std::vector<std::uint8_t> may_stand_;  ///< per map cell
  std::vector<std::uint16_t> standing_;  ///< map cells in it where the body may stand
  // Of the search that is under way.
  std::vector<std::vector<std::uint32_t>> buckets_;
  std::uint32_t from_ = 0;
  std::int32_t begin_ = 0;
  std::int32_t limit_ = 0;
  std::int32_t bucket_distance_ = 0;
  std::size_t bucket_next_ = 0;
  std::size_t waiting_ = 0;
};

}  // namespace g3d::nav
