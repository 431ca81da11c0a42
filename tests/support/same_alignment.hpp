// SPDX-License-Identifier: Apache-2.0
// Whether two aligners have made the same of the same frames, to the last bit.
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "mapper/align/aligner.hpp"

namespace g3d::test {

[[nodiscard]] inline bool are_equal(const mapper::align::AlignResult& a, const mapper::align::AlignResult& b) {
  return a.outcome == b.outcome && a.T_world_camera.translation_m == b.T_world_camera.translation_m &&
         a.T_world_camera.rotation_xyzw == b.T_world_camera.rotation_xyzw && a.correction == b.correction &&
         a.matched == b.matched && a.residual_m == b.residual_m && a.surprise == b.surprise &&
         a.holds_shift == b.holds_shift && a.holds_turn == b.holds_turn;
}

/// In an order of their own: where in the table they lie depends on who came first.
[[nodiscard]] inline std::vector<mapper::align::SurfaceCell> cells_of(const mapper::align::SurfaceMap& map) {
  std::vector<mapper::align::SurfaceCell> cells;
  for (const mapper::align::SurfaceCell& cell : map.table()) {
    if (cell.key != 0) cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
  return cells;
}

[[nodiscard]] inline bool are_equal(const mapper::align::SurfaceMap& a, const mapper::align::SurfaceMap& b) {
  const auto of_a = cells_of(a);
  const auto of_b = cells_of(b);
  return a.piece_count() == b.piece_count() && a.unsteady_count() == b.unsteady_count() && a.refused() == b.refused() &&
         a.next_swept().first == b.next_swept().first && of_a.size() == of_b.size() &&
         std::memcmp(of_a.data(), of_b.data(), of_a.size() * sizeof(mapper::align::SurfaceCell)) == 0;
}

}  // namespace g3d::test
