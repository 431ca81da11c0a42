// SPDX-License-Identifier: Apache-2.0
// Sills, cable ducts and edges of 2 to 5 cm: too low for a map of 5 cm cells, too high for the wheels. Single readings
// of the floor within two metres are good to half a centimetre, so along a column of the image the floor is followed
// upwards from the lower edge, and where it suddenly goes on higher or lower there is a step. A cell is one only after
// several rays said so, and is none any more when as many passed over it without noticing anything.
//
//    h ──────┬ ─ ─ kMost_m: from here on the map knows it as an obstacle
//            │   ____
//            ├ ─|────|─ kLeast_m: what is lower is driven over
//    ________│__|    |___________     ___ the same downwards: an edge at the last reading before it
//                                |___|
#pragma once

#include <cstdint>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "nav/move_field.hpp"

namespace g3d::nav {

struct FloorStepsConfig {
  hal::Pose T_base_camera = {{0.0, 0.0, 0.5}, {-0.5, 0.5, -0.5, 0.5}};  ///< half a metre up, looking ahead
  double far_m = 2.0;                                                   ///< farther off noise is as large as the steps
};

class FloorSteps {
 public:
  static constexpr double kLeast_m = 0.022;
  static constexpr double kMost_m = 0.06;

  FloorSteps(const CellGrid<CellState>& like, const FloorStepsConfig& config);

  /// A frame was taken here. Allocates nothing; looks at a fixed number of pixels, whatever the image's size.
  void look(const hal::Frame& frame, const hal::CameraModel& camera, const CellGrid<CellState>& states,
            const hal::PlanarPose& T_world_base);

  /// The map has moved. `scratch`: as many cells. changed_cells() says nothing of it: see for_steps().
  void move(const MoveField& field, std::vector<std::uint8_t>& scratch) { field.resample(votes_, scratch); }
  template <typename Visit>
  void for_steps(Visit visit) const {
    for (std::size_t i = 0; i < votes_.cells.size(); ++i) {
      if (votes_.cells[i] >= kStep) visit(votes_.cell(i));
    }
  }
  [[nodiscard]] bool is_step(Cell c) const { return votes_.contains(c) && votes_.at(c) >= kStep; }
  /// Cells of which the last look() changed the judgement. May name one twice.
  [[nodiscard]] const std::vector<std::uint32_t>& changed_cells() const { return changed_; }

 private:
  static constexpr int kColumns = 80;
  static constexpr int kRows = 64;  ///< in the lower half of the image
  static constexpr std::uint8_t kStep = 10;
  static constexpr std::uint8_t kMostVotes = 24;

  struct Reading {
    double distance_m;  ///< over the floor, from the camera
    double height_m;    ///< above the floor that the base stands on
    double x_m;         ///< base frame
    double y_m;
  };
  using Column = std::vector<Reading>;

  void read_column(const hal::Frame& frame, const hal::CameraModel& camera, int u);
  void judge_column(const CellGrid<CellState>& states, const hal::PlanarPose& T_world_base);
  [[nodiscard]] bool goes_on(std::size_t first, double level_m) const;
  [[nodiscard]] Cell cell_of(const Reading& reading, const hal::PlanarPose& T_world_base) const;
  void vote(Cell c, bool is_step);

  FloorStepsConfig config_;
  hal::RigidTransform T_base_camera_;
  CellGrid<std::uint8_t> votes_;
  Column column_;
  std::vector<std::uint32_t> changed_;
};

}  // namespace g3d::nav
