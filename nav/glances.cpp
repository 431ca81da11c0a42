// SPDX-License-Identifier: Apache-2.0
#include "nav/glances.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kApart_m = 0.3;
constexpr double kRim_rad = 0.1;  // of the view: what is there may just have come in
constexpr double kSpare_m = 0.1;  // beyond the nearest that can be measured
constexpr double kClear_m = 2.0;  // nearer than this a camera half a metre up sees floor and all
constexpr int kRays = 3;  // in plain view, not just past an edge: rays are 6 cm apart at 2 m, a target is 20 cm wide
constexpr hal::TimeNs kWhile_ns = 700'000'000;  // in view for so long: several frames
constexpr hal::TimeNs kLongAgo_ns = 3'000'000'000;

}  // namespace

void Glances::reset(const Targets& targets) {
  targets_.assign(targets.size(), Target{});
  round_ = 1;
  looked_ns_ = 0;
}

void Glances::look(const CellGrid<CellState>& ground, const Targets& targets, const ViewGain& camera,
                   const hal::PlanarPose& T_world_base, hal::TimeNs now) {
  const Cell at = ground.cell_of(T_world_base.x_m, T_world_base.y_m);
  if (!ground.contains(at) || now - looked_ns_ < kWhile_ns) return;
  // A look long ago says nothing of what stayed.
  round_ += now - looked_ns_ < kLongAgo_ns ? 1 : 2;
  looked_ns_ = now;
  camera.look(ground, at, panorama_);
  const ViewModel& model = camera.model();
  for (int ray = 0; ray < kViewRays; ++ray) {
    const std::uint32_t entry = panorama_[static_cast<std::size_t>(ray)].entry;
    if (entry == RayGain::kNothing) continue;
    const double bearing = (ray + 0.5) * kBearing_rad / kRaysPerBearing;
    const double off_axis = std::fabs(std::remainder(bearing - T_world_base.heading_rad, 6.283185307179586));
    if (off_axis > 0.5 * model.view_rad - kRim_rad) continue;
    const Cell c = ground.cell(entry);
    const double range_m = std::hypot(c.x - at.x, c.y - at.y) * ground.resolution_m - model.forward_m;
    if (range_m < model.near_m + kSpare_m || range_m > std::min(kClear_m, model.far_m)) continue;
    Target& target = targets_[targets.of_cell(entry)];
    if (target.round != round_) {
      target.was_in_view = target.round + 1 == round_ && target.rays >= kRays;
      target.round = round_;
      target.rays = 0;
    }
    if (++target.rays != kRays || !target.was_in_view || target.count == 255) continue;
    const double apart_m = std::hypot(target.x - at.x, target.y - at.y) * ground.resolution_m;
    if (target.count != 0 && apart_m < kApart_m) continue;
    ++target.count;
    target.x = static_cast<std::int16_t>(at.x);
    target.y = static_cast<std::int16_t>(at.y);
  }
}

}  // namespace g3d::nav
