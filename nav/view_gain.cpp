// SPDX-License-Identifier: Apache-2.0
#include "nav/view_gain.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

/// What is unknown nearer than the camera measures is shown only if nothing stands there.
constexpr float kNearHope = 0.3F;

}  // namespace

ViewGain::ViewGain(const ViewModel& model, double resolution_m) : model_(model) {
  window_ = std::clamp(static_cast<int>(model.view_rad / kBearing_rad), 1, kBearings);
  const double ahead_cells = model.forward_m / resolution_m;
  const double far_cells = model.far_m / resolution_m + ahead_cells;
  constexpr double kRay_rad = 6.283185307179586 / kViewRays;
  for (int ray = 0; ray < kViewRays; ++ray) {
    first_[static_cast<std::size_t>(ray)] = static_cast<std::uint32_t>(steps_.size());
    const double angle = (ray + 0.5) * kRay_rad;
    const double dx = std::cos(angle);
    const double dy = std::sin(angle);
    // Amanatides and Woo 1987, from the middle of cell (0, 0); no ray is parallel to an axis.
    double next_x = 0.5 / std::abs(dx);
    double next_y = 0.5 / std::abs(dy);
    int x = 0;
    int y = 0;
    double at = 0.0;
    while (at < far_cells) {
      const double leave = std::min({next_x, next_y, far_cells});
      Step step;
      step.dx = static_cast<std::int16_t>(x);
      step.dy = static_cast<std::int16_t>(y);
      step.range_m = static_cast<float>((at - ahead_cells) * resolution_m);
      step.cells = static_cast<float>((leave * leave - at * at) / 2 * kRay_rad);
      step.fade = static_cast<float>(std::exp(-(leave - at) * resolution_m / model.hope_m));
      steps_.push_back(step);
      at = leave;
      if (next_x < next_y) {
        next_x += 1.0 / std::abs(dx);
        x += dx > 0 ? 1 : -1;
      } else {
        next_y += 1.0 / std::abs(dy);
        y += dy > 0 ? 1 : -1;
      }
    }
  }
  first_[kViewRays] = static_cast<std::uint32_t>(steps_.size());
}

void ViewGain::look(const CellGrid<CellState>& ground, Cell at, PanoramaGain& out) const {
  const float near_m = static_cast<float>(model_.near_m);
  const unsigned columns = static_cast<unsigned>(ground.columns);
  const unsigned rows = static_cast<unsigned>(ground.rows);
  for (std::size_t ray = 0; ray < kViewRays; ++ray) {
    RayGain gain;
    float hope = 1.0F;
    std::uint32_t before = RayGain::kNothing;
    for (std::uint32_t k = first_[ray]; k < first_[ray + 1]; ++k) {
      const Step& step = steps_[k];
      const unsigned x = static_cast<unsigned>(at.x + step.dx);
      const unsigned y = static_cast<unsigned>(at.y + step.dy);
      if (x >= columns || y >= rows) break;
      const std::uint32_t i = y * columns + x;
      const CellState state = ground.cells[i];
      if (state == CellState::occupied) {
        if (step.range_m < near_m) gain = {};
        break;
      }
      if (state == CellState::unknown && step.range_m >= 0.0F) {
        if (gain.entry == RayGain::kNothing) {
          if (before == RayGain::kNothing) break;
          gain.entry = before;
          if (step.range_m < near_m) hope = kNearHope;
        }
        gain.cells += hope * step.cells;
        hope *= step.fade;
      }
      before = i;
    }
    out[ray] = gain;
  }
}

}  // namespace g3d::nav
