// SPDX-License-Identifier: Apache-2.0
// Where a robot can get to, known from the world itself: cells of its floor plan on whose middle the body fits with
// floor under it, connected to where it starts. The truth that reports compare with; robots never see it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/result.hpp"
#include "hal/sim/floor_contact.hpp"
#include "hal/twist.hpp"

namespace g3d::hal {

/// Square cells on the floor. Edges lie on multiples of the cell's side, as those of the voxel map do.
struct PlanFrame {
  double cell_m = 0.05;
  int first_x = 0;  ///< cell (0, 0) covers [first_x * cell_m, + cell_m] in x
  int first_y = 0;
  int columns = 0;
  int rows = 0;

  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  [[nodiscard]] bool contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < columns && row < rows;
  }
  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
  [[nodiscard]] int column_of(double x_m) const;
  [[nodiscard]] int row_of(double y_m) const;
  [[nodiscard]] double x_m(int column) const { return (first_x + column + 0.5) * cell_m; }
  [[nodiscard]] double y_m(int row) const { return (first_y + row + 0.5) * cell_m; }
};

inline constexpr std::size_t kMaxPlanCells = std::size_t{1} << 26;

/// All that stands still in the world, grid included.
[[nodiscard]] Result<PlanFrame> plan_frame(const World& world, double cell_m = 0.05);

struct ReachOptions {
  double radius_m = 0.18;
  HeightSlice body{kClimb_m, 0.60};
};

/// Whether a robot can stand here, people and robots aside.
[[nodiscard]] bool fits(const FloorContact& floor, double x_m, double y_m, const ReachOptions& options);

/// Per cell of the frame, 1 where a robot can get from one of the starts. A start that does not fit reaches nothing.
[[nodiscard]] std::vector<std::uint8_t> reachable_cells(const FloorContact& floor, const PlanFrame& frame,
                                                        std::span<const PlanarPose> starts,
                                                        const ReachOptions& options = {});

/// `count` poses for robots. Seed 1 takes the world's own starts as far as there are enough of them. Other seeds draw
/// reachable places with 10 cm to spare and any heading; so does seed 1 where the world names no start: then from the
/// widest connected part of the floor that some tries find. No two nearer than 0.6 m. A start of
/// the world that has no room for a robot is an error (bad_usage).
[[nodiscard]] Result<std::vector<PlanarPose>> choose_starts(const World& world, std::size_t count, std::uint64_t seed,
                                                            const ReachOptions& options = {});

}  // namespace g3d::hal
