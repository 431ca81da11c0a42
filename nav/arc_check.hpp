// SPDX-License-Identifier: Apache-2.0
// How far the robot's body, a disc, gets along an arc before it meets something: an occupied cell, or one that nobody
// has seen. Cells are squares, not points: an obstacle may stand anywhere in its cell. Where there is no other way the
// body may come nearer to such a square by kSlack_m than the margin, slowly.
#pragma once

#include <cstdint>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"

namespace g3d::nav {

/// What an occupied cell may be taken for where there is no other way.
enum class Extent : std::uint8_t { square, middle, nothing };

/// Whether the floor itself was seen in a cell that counts as free (GroundMap: else it is only presumed).
class FloorKnowledge {
 public:
  virtual ~FloorKnowledge() = default;
  [[nodiscard]] virtual bool is_seen(Cell c) const = 0;
  /// Something that the map does not know (yet) may stand here: as good as occupied.
  [[nodiscard]] virtual bool is_suspect(Cell) const { return false; }
  /// The camera has not looked here lately, and somebody who is about could have come.
  [[nodiscard]] virtual bool is_unwatched(Cell) const { return false; }
  /// Of an occupied cell that is not suspect.
  [[nodiscard]] virtual Extent extent(Cell) const { return Extent::square; }
};

struct ArcView {
  double free_m = 0.0;       ///< the centre may go this far over seen floor, clear of obstacles with the margin
  double clear_m = 0.0;      ///< ... over any floor, clear of obstacles with the margin less the slack
  bool is_doubtful = false;  ///< free_m ends at a cell that is unknown or presumed, not at an obstacle
  double watched_m = 0.0;    ///< the body may go this far before it sweeps over what is free but unwatched
  double clearance_m = 0.0;  ///< least distance from the body to an occupied cell on the way, at most kNoticed_m
};

/// Sees only what lies around the robot: gather() once per step, then look() along as many arcs as wanted.
class ArcCheck {
 public:
  static constexpr double kNoticed_m = 0.12;  ///< obstacles farther from the body do not slow it down
  static constexpr double kStep_m = 0.025;
  static constexpr double kSlack_m = 0.010;

  /// `reach_m`: the longest arc. Memory is reserved here.
  ArcCheck(double body_radius_m, double touch_margin_m, double reach_m, double resolution_m);

  /// What lies outside of the grid is unknown. Cells that the body covers or touches already do not count as long as
  /// it gets no deeper into them, so that a robot that stands against a wall can leave it.
  /// Without `floor` all free cells count as seen.
  void gather(const CellGrid<CellState>& ground, const hal::PlanarPose& T_world_base,
              const FloorKnowledge* floor = nullptr);

  /// `curvature_per_m` > 0 turns left when driving forward. `backward`: the same circle, the other way.
  /// `trusting`: occupied cells are what FloorKnowledge::extent() says, not squares.
  [[nodiscard]] ArcView look(double curvature_per_m, double length_m, bool backward = false,
                             bool trusting = false) const;

  /// Distance from the body to the nearest occupied cell, below 0 when inside; at most the reach.
  [[nodiscard]] double clearance_m() const { return clearance_here_m_; }

 private:
  struct NearCell {
    double x_m;  ///< centre, relative to the robot, world axes
    double y_m;
    double start_m;  ///< distance from the robot's centre to the cell
    bool occupied;
    Extent extent;
    bool unwatched;  ///< free, and seen once
  };
  /// To the square of an occupied cell, to the middle of any other.
  [[nodiscard]] double distance_m(const NearCell& cell, double x_m, double y_m) const;
  [[nodiscard]] double distance_m(const NearCell& cell, double x_m, double y_m, bool trusting) const;

  double body_radius_m_;
  double touch_margin_m_;
  double reach_m_;
  double half_cell_m_ = 0.0;
  double clearance_here_m_ = 0.0;
  double trusted_here_m_ = 0.0;
  double forward_x_ = 1.0;  ///< the robot's x axis in the world
  double forward_y_ = 0.0;
  std::vector<NearCell> cells_;
};

}  // namespace g3d::nav
