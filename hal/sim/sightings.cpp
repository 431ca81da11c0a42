// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/sightings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace g3d::hal {
namespace {

constexpr int kSlices = 32;  // of 5 cm from the floor upwards; what is higher hides nothing that matters
constexpr double kSlice_m = 0.05;
constexpr double kAzimuthStep_deg = 0.5;
constexpr double kGrazing = 0.08;  // slope below which a level surface gives no reading (kinect_noise.hpp)

std::uint32_t slices_between(double low_m, double high_m) {
  std::uint32_t bits = 0;
  for (int s = 0; s < kSlices; ++s) {
    if (low_m < (s + 1) * kSlice_m - 1e-4 && high_m > s * kSlice_m + 1e-4) bits |= 1U << s;
  }
  return bits;
}

}  // namespace

Sightings::Sightings(const World& world, const PlanFrame& frame, const ObservableOptions& options)
    : frame_(frame), columns_(frame.count()) {
  for (const Primitive& p : world.primitives()) {
    if (p.mover < 0 && !p.material.glass && upper_side_m(p) > kClimb_m) add(p);
  }
  if (world.grid()) add(*world.grid());
  make_rays(options);
  make_steps(options);
  for (int s = 0; s < kSlices; ++s) {
    if (s * kSlice_m >= options.band.low_m - 1e-6 && (s + 1) * kSlice_m <= options.band.high_m + 1e-6) {
      band_slices_ |= 1U << s;
    }
  }
}

/// Cells that the solid's plan overlaps, give or take a millimetre: a face along a cell's edge is in one cell only.
void Sightings::add(const Primitive& p) {
  const double reach_m = frame_.cell_m / 2.0 - 1e-3;
  const PlanExtent half = plan_extent(p);
  const int low_c = std::max(frame_.column_of(double{p.centre_m[0]} - half.x_m - frame_.cell_m), 0);
  const int high_c = std::min(frame_.column_of(double{p.centre_m[0]} + half.x_m + frame_.cell_m), frame_.columns - 1);
  const int low_r = std::max(frame_.row_of(double{p.centre_m[1]} - half.y_m - frame_.cell_m), 0);
  const int high_r = std::min(frame_.row_of(double{p.centre_m[1]} + half.y_m + frame_.cell_m), frame_.rows - 1);
  const std::uint32_t all = slices_between(underside_m(p), upper_side_m(p));
  const auto overlaps = [&](const HeightSlice& slice, int c, int r) {
    return nearest_in_plan(p, slice, frame_.x_m(c), frame_.y_m(r)).distance_m < reach_m;
  };
  for (int r = low_r; r <= high_r; ++r) {
    for (int c = low_c; c <= high_c; ++c) {
      if (!overlaps({underside_m(p), upper_side_m(p)}, c, r)) continue;
      std::uint32_t bits = all;
      if (p.shape == Shape::sphere || p.shape == Shape::cone) {
        for (int s = 0; s < kSlices; ++s) {
          if ((bits >> s & 1U) != 0 && !overlaps({s * kSlice_m, (s + 1) * kSlice_m}, c, r)) bits &= ~(1U << s);
        }
      }
      Column& column = columns_[frame_.index(c, r)];
      column.dark = p.material.dark ? column.dark | (bits & ~column.opaque) : column.dark & ~bits;
      column.opaque |= bits;
    }
  }
}

void Sightings::add(const GridWalls& grid) {
  const std::uint32_t bits = slices_between(grid.z_low_m(), grid.z_high_m());
  const double z_m = (double{grid.z_low_m()} + double{grid.z_high_m()}) / 2.0;
  const double inset_m = frame_.cell_m / 2.0 - 1e-3;
  for (int r = 0; r < frame_.rows; ++r) {
    for (int c = 0; c < frame_.columns; ++c) {
      bool solid = false;
      for (const double dx : {-inset_m, 0.0, inset_m}) {
        for (const double dy : {-inset_m, 0.0, inset_m}) {
          solid = solid || grid.is_solid(static_cast<float>(frame_.x_m(c) + dx), static_cast<float>(frame_.y_m(r) + dy),
                                         static_cast<float>(z_m));
        }
      }
      if (!solid) continue;
      columns_[frame_.index(c, r)].opaque |= bits;
      columns_[frame_.index(c, r)].dark &= ~bits;
    }
  }
}

void Sightings::make_rays(const ObservableOptions& options) {
  const double far_cells = options.far_m / options.cell_m;
  for (double azimuth_deg = 0.0; azimuth_deg < 360.0; azimuth_deg += kAzimuthStep_deg) {
    const double c = std::cos(azimuth_deg * std::numbers::pi / 180.0);
    const double s = std::sin(azimuth_deg * std::numbers::pi / 180.0);
    std::vector<RayCell> ray;
    for (double d = 0.25; d <= far_cells; d += 0.25) {
      const auto dx = static_cast<std::int16_t>(std::floor(d * c + 0.5));
      const auto dy = static_cast<std::int16_t>(std::floor(d * s + 0.5));
      if (dx == 0 && dy == 0) continue;
      if (!ray.empty() && ray.back().dx == dx && ray.back().dy == dy) continue;
      const double cells = std::sqrt(static_cast<double>(dx) * dx + static_cast<double>(dy) * dy);
      ray.push_back({dx, dy, static_cast<std::int16_t>(std::floor(cells + 0.5))});
    }
    rays_.push_back(std::move(ray));
  }
}

void Sightings::make_steps(const ObservableOptions& options) {
  const auto slope_of = [&options](int beam) { return options.half_height_tan * (2.0 * (beam + 0.5) / kBeams - 1.0); };
  steps_.resize(static_cast<std::size_t>(options.far_m / options.cell_m) + 3);
  for (std::size_t n = 0; n < steps_.size(); ++n) {
    const double d_m = static_cast<double>(n) * options.cell_m;
    steps_[n].in_range = d_m >= options.near_m && d_m <= options.far_m;
    for (int b = 0; b < kBeams; ++b) {
      const double slope = slope_of(b);
      const double z_m = options.camera_height_m + d_m * slope;
      steps_[n].slice[static_cast<std::size_t>(b)] =
          static_cast<std::int16_t>(std::clamp(static_cast<int>(std::floor(z_m / kSlice_m)), -1, kSlices));
      if (z_m > 0.0) steps_[n].above_floor |= 1U << b;
      if (z_m > options.band.low_m && z_m < options.band.high_m) steps_[n].in_band |= 1U << b;
    }
  }
  for (int b = 0; b < kBeams; ++b) {
    if (std::abs(slope_of(b)) < kGrazing) grazing_ |= 1U << b;
  }
}

std::uint32_t Sightings::beams_that_meet(const BeamStep& step, std::uint32_t slices) {
  std::uint32_t met = 0;
  for (std::size_t b = 0; b < kBeams; ++b) {
    const int s = step.slice[b];
    if (s >= 0 && s < kSlices && (slices >> s & 1U) != 0) met |= 1U << b;
  }
  return met;
}

}  // namespace g3d::hal
