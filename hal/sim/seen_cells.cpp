// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/seen_cells.hpp"

#include <algorithm>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr int kColumns = 80;  // of the image that are looked at, and rows
constexpr int kRows = 12;
constexpr double kNear_m = 0.8;  // depth z
constexpr double kFar_m = 3.5;
constexpr HeightSlice kBand{0.05, 0.60};

}  // namespace

SeenCells::SeenCells(const Observable& observable) : observable_(&observable), seen_(observable.cells.size()) {}

void SeenCells::mark(double x_m, double y_m, SeenCell what) {
  const PlanFrame& plan = observable_->frame;
  const int column = plan.column_of(x_m), row = plan.row_of(y_m);
  // A surface on the edge of two cells may be measured in either.
  const int beside = what == SeenCell::wall ? 1 : 0;
  for (int r = row - beside; r <= row + beside; ++r) {
    for (int c = column - beside; c <= column + beside; ++c) {
      if (!plan.contains(c, r)) continue;
      const std::size_t index = plan.index(c, r);
      if (observable_->cells[index] == what) seen_[index].store(1, std::memory_order_relaxed);
    }
  }
}

void SeenCells::look(const Frame& frame, const CameraModel& camera, const Pose& T_world_camera) {
  const RigidTransform T = to_transform(T_world_camera);
  const int across = std::max(camera.width_px / kColumns, 1), down = std::max(camera.height_px / kRows, 1);
  for (int v = down / 2; v < camera.height_px; v += down) {
    for (int u = across / 2; u < camera.width_px; u += across) {
      const std::uint16_t raw = frame.depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width_px) +
                                            static_cast<std::size_t>(u)];
      const double z_m = raw / static_cast<double>(camera.depth_units_per_metre);
      if (raw == 0 || z_m < kNear_m) continue;
      const std::array<double, 3> ray = {(u - camera.cx_px) / static_cast<double>(camera.fx_px),
                                         (v - camera.cy_px) / static_cast<double>(camera.fy_px), 1.0};
      const auto at = [&](double depth_m) {
        std::array<double, 3> point{};
        for (std::size_t i = 0; i < 3; ++i) {
          const double along = static_cast<double>(T.rotation[3 * i]) * ray[0] +
                               static_cast<double>(T.rotation[3 * i + 1]) * ray[1] +
                               static_cast<double>(T.rotation[3 * i + 2]) * ray[2];
          point[i] = static_cast<double>(T.translation_m[i]) + depth_m * along;
        }
        return point;
      };
      const double cell_m = observable_->frame.cell_m;
      const auto is_in_band = [](double height_m) { return height_m >= kBand.low_m && height_m <= kBand.high_m; };
      for (double d_m = kNear_m; d_m < std::min(z_m - cell_m, kFar_m); d_m += 0.5 * cell_m) {
        const auto point = at(d_m);
        if (is_in_band(point[2])) mark(point[0], point[1], SeenCell::free);
      }
      if (const auto end = at(z_m); z_m <= kFar_m && is_in_band(end[2])) mark(end[0], end[1], SeenCell::wall);
    }
  }
}

double SeenCells::fraction() const { return fraction({this}); }

double SeenCells::fraction(const std::vector<const SeenCells*>& cameras) {
  if (cameras.empty() || cameras.front()->observable_->count() == 0) return 1.0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < cameras.front()->seen_.size(); ++i) {
    seen += std::any_of(cameras.begin(), cameras.end(),
                        [i](const SeenCells* camera) { return camera->seen_[i].load(std::memory_order_relaxed) != 0; });
  }
  return static_cast<double>(seen) / static_cast<double>(cameras.front()->observable_->count());
}

}  // namespace g3d::hal
