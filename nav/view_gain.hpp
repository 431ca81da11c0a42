// SPDX-License-Identifier: Apache-2.0
// What a camera at a place would newly show, in every direction. Rays leave the centre of a cell and cross the known
// map: free cells let them pass, occupied ones end them, and what is unknown counts, the less the deeper it lies behind
// other unknown cells, because something may stand there. A ray that ends nearer than the camera can measure shows
// nothing.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nav/cell_grid.hpp"

namespace g3d::nav {

struct ViewModel {
  double near_m = 0.8;
  double far_m = 3.5;
  double view_rad = 0.995;
  double forward_m = 0.0;  ///< camera in front of the place, whichever way it is turned
  double hope_m = 1.5;     ///< depth into the unknown at which the chance of still seeing on has fallen to 1/e
};

inline constexpr int kBearings = 72;       ///< 5 degrees each; bearing b covers [b, b + 1) * 5 degrees from world x
inline constexpr int kRaysPerBearing = 3;  ///< 10 cm apart at 3.5 m
inline constexpr int kViewRays = kBearings * kRaysPerBearing;
inline constexpr double kBearing_rad = 6.283185307179586 / kBearings;

/// What one ray would show.
struct RayGain {
  static constexpr std::uint32_t kNothing = 0xFFFFFFFF;
  std::uint32_t entry = kNothing;  ///< frontier cell through which it enters the unknown
  float cells = 0.0F;              ///< expected number of unknown cells; each counts once over all rays of a place
};
using PanoramaGain = std::array<RayGain, kViewRays>;

class ViewGain {
 public:
  ViewGain(const ViewModel& model, double resolution_m);

  /// Everything that could be seen from the middle of `at` by turning around.
  void look(const CellGrid<CellState>& ground, Cell at, PanoramaGain& out) const;

  /// Bearings that the camera sees at once; a little fewer than its view holds, so that what is promised is seen.
  [[nodiscard]] int window() const { return window_; }
  [[nodiscard]] const ViewModel& model() const { return model_; }

 private:
  struct Step {
    std::int16_t dx = 0;
    std::int16_t dy = 0;
    float range_m = 0.0F;  ///< from the camera to where the ray enters the cell; negative between place and camera
    float cells = 0.0F;    ///< area that it stands for in this cell
    float fade = 1.0F;     ///< factor on hope when the cell is unknown
  };

  ViewModel model_;
  int window_ = 1;
  std::vector<Step> steps_;
  std::array<std::uint32_t, kViewRays + 1> first_{};
};

}  // namespace g3d::nav
