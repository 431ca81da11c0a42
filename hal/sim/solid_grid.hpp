// SPDX-License-Identifier: Apache-2.0
// Which solids may be near a place: squares on the floor, each with the solids whose plan comes within a margin of it.
// The squares grow until the lists are bounded, so that no world from outside can ask for much memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/sim/world.hpp"

namespace g3d::hal {

class SolidGrid {
 public:
  /// `indices`: of those primitives of the world that matter here; none of them moves.
  SolidGrid(const World& world, const std::vector<std::int32_t>& indices, double margin_m);

  /// All of `indices` with any part within the margin of (x, y), and some others; ascending. Allocates nothing.
  [[nodiscard]] std::span<const std::int32_t> near(double x_m, double y_m) const;

 private:
  double origin_x_m_ = 0.0;
  double origin_y_m_ = 0.0;
  double side_m_ = 1.0;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::uint32_t> first_;  ///< per square, where its list begins in solids_; one more at the end
  std::vector<std::int32_t> solids_;
};

}  // namespace g3d::hal
