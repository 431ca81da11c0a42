// SPDX-License-Identifier: Apache-2.0
// One robot on a floor plan: a disc that drives and turns within limits, a camera that sees a slice of the plan between
// its near and far limit, and the map that it makes of it. No drift, no noise: it measures decisions, not sensors.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/twist.hpp"
#include "nav/cell_grid.hpp"
#include "tests/support/flat_world.hpp"

namespace g3d::tests {

struct FlatCamera {
  double view_rad = 0.995;
  double near_m = 0.8;  ///< along the optical axis, as is far_m
  double far_m = 3.5;
  int rays = 160;
};

struct FlatLimits {
  double speed_mps = 0.4;
  double turn_radps = 1.0;
};

class FlatSim {
 public:
  static constexpr double kStep_s = 0.1;

  FlatSim(const FlatWorld& world, const hal::PlanarPose& start, const FlatCamera& camera = {});

  /// Moves by one step, clamped to the limits, and looks. A step that would touch something is not made: false, and the
  /// cell that it would have touched is mapped as occupied, as a bumper does.
  bool step(double forward_mps, double turn_radps);

  [[nodiscard]] const hal::PlanarPose& pose() const { return pose_; }
  [[nodiscard]] double time_s() const { return static_cast<double>(steps_) * kStep_s; }
  [[nodiscard]] const nav::CellGrid<nav::CellState>& ground() const { return ground_; }
  [[nodiscard]] const nav::CellGrid<std::uint8_t>& cost() const { return cost_; }
  /// Since the last take; may repeat.
  [[nodiscard]] std::vector<std::uint32_t> take_changed();

  [[nodiscard]] int contacts() const { return contacts_; }
  [[nodiscard]] double path_m() const { return path_m_; }
  [[nodiscard]] double turned_rad() const { return turned_rad_; }

  /// Cells that are observable and known; and all that are observable.
  [[nodiscard]] std::size_t covered() const { return covered_; }
  [[nodiscard]] std::size_t observable() const { return observable_total_; }
  void set_observable(const nav::CellGrid<std::uint8_t>* observable);
  [[nodiscard]] double coverage() const {
    return static_cast<double>(covered_) / static_cast<double>(observable_total_);
  }

 private:
  struct Stamp {
    int dx = 0;
    int dy = 0;
    std::uint8_t cost = 0;
  };

  void look();
  void learn(std::size_t cell, nav::CellState state);

  const FlatWorld& world_;
  nav::CellGrid<float> clearance_;
  FlatCamera camera_;
  FlatLimits limits_;
  hal::PlanarPose pose_;
  std::int64_t steps_ = 0;
  nav::CellGrid<nav::CellState> ground_;
  nav::CellGrid<std::uint8_t> inflated_;
  nav::CellGrid<std::uint8_t> cost_;
  std::vector<Stamp> stamps_;
  std::vector<std::uint32_t> changed_;
  const nav::CellGrid<std::uint8_t>* observable_ = nullptr;
  std::size_t covered_ = 0;
  std::size_t observable_total_ = 1;
  int contacts_ = 0;
  double path_m_ = 0.0;
  double turned_rad_ = 0.0;
};

[[nodiscard]] double wrap_angle(double rad);

/// The cost of a plan that is all known.
[[nodiscard]] nav::CellGrid<std::uint8_t> true_costs(const nav::CellGrid<std::uint8_t>& solid);

}  // namespace g3d::tests
