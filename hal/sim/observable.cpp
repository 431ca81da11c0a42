// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/observable.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace g3d::hal {
namespace {

constexpr int kSlices = 32;  // of 5 cm from the floor upwards; what is higher hides nothing that matters
constexpr double kSlice_m = 0.05;
constexpr std::uint32_t kWholeColumn = ~0U;
constexpr int kBeams = 32;  // of one column of the image
constexpr double kAzimuthStep_deg = 0.5;
constexpr double kGrazing = 0.08;  // slope below which a level surface gives no reading (kinect_noise.hpp)

/// What fills a column over one cell, a bit per slice.
struct Column {
  std::uint32_t opaque = 0;
  std::uint32_t dark = 0;  ///< of the opaque ones, those without a reading
};

/// One cell on the way of a ray, as an offset from where it begins, and what its beams do at that distance.
struct RayCell {
  std::int16_t dx = 0;
  std::int16_t dy = 0;
  std::int16_t step = 0;
};

struct BeamStep {
  std::array<std::int16_t, kBeams> slice{};  ///< in which the beam is here; kSlices and more: above all
  std::uint32_t above_floor = 0;             ///< beams that have not met the floor
  std::uint32_t in_band = 0;
  bool in_range = false;
};

class ColumnMap {
 public:
  ColumnMap(const World& world, const PlanFrame& frame) : frame_(frame), columns_(frame.count()) {
    for (const Primitive& p : world.primitives()) {
      if (p.mover < 0 && !p.material.glass && upper_side_m(p) > kClimb_m) add(p);
    }
    if (world.grid()) add(*world.grid());
  }
  [[nodiscard]] const Column& at(std::size_t index) const { return columns_[index]; }

 private:
  static std::uint32_t slices_between(double low_m, double high_m) {
    std::uint32_t bits = 0;
    for (int s = 0; s < kSlices; ++s) {
      if (low_m < (s + 1) * kSlice_m - 1e-4 && high_m > s * kSlice_m + 1e-4) bits |= 1U << s;
    }
    return bits;
  }

  /// Cells that the solid's plan overlaps, give or take a millimetre: a face along a cell's edge is in one cell only.
  void add(const Primitive& p) {
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

  void add(const GridWalls& grid) {
    const std::uint32_t bits = slices_between(grid.z_low_m(), grid.z_high_m());
    const double z_m = (double{grid.z_low_m()} + double{grid.z_high_m()}) / 2.0;
    const double inset_m = frame_.cell_m / 2.0 - 1e-3;
    for (int r = 0; r < frame_.rows; ++r) {
      for (int c = 0; c < frame_.columns; ++c) {
        bool solid = false;
        for (const double dx : {-inset_m, 0.0, inset_m}) {
          for (const double dy : {-inset_m, 0.0, inset_m}) {
            solid = solid || grid.is_solid(static_cast<float>(frame_.x_m(c) + dx),
                                           static_cast<float>(frame_.y_m(r) + dy), static_cast<float>(z_m));
          }
        }
        if (!solid) continue;
        columns_[frame_.index(c, r)].opaque |= bits;
        columns_[frame_.index(c, r)].dark &= ~bits;
      }
    }
  }

  const PlanFrame& frame_;
  std::vector<Column> columns_;
};

/// Cells of one ray in every direction, nearest first, without the cell it begins in.
std::vector<std::vector<RayCell>> make_rays(const ObservableOptions& options) {
  std::vector<std::vector<RayCell>> rays;
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
    rays.push_back(std::move(ray));
  }
  return rays;
}

double beam_slope(const ObservableOptions& options, int beam) {
  return options.half_height_tan * (2.0 * (beam + 0.5) / kBeams - 1.0);
}

/// Beams at every whole distance in cells.
std::vector<BeamStep> make_steps(const ObservableOptions& options) {
  std::vector<BeamStep> steps(static_cast<std::size_t>(options.far_m / options.cell_m) + 3);
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const double d_m = static_cast<double>(n) * options.cell_m;
    steps[n].in_range = d_m >= options.near_m && d_m <= options.far_m;
    for (int b = 0; b < kBeams; ++b) {
      const double slope = beam_slope(options, b);
      const double z_m = options.camera_height_m + d_m * slope;
      steps[n].slice[static_cast<std::size_t>(b)] =
          static_cast<std::int16_t>(std::clamp(static_cast<int>(std::floor(z_m / kSlice_m)), -1, kSlices));
      if (z_m > 0.0) steps[n].above_floor |= 1U << b;
      if (z_m > options.band.low_m && z_m < options.band.high_m) steps[n].in_band |= 1U << b;
    }
  }
  return steps;
}

std::uint32_t beams_that_meet(const BeamStep& step, std::uint32_t slices) {
  std::uint32_t met = 0;
  for (std::size_t b = 0; b < kBeams; ++b) {
    const int s = step.slice[b];
    if (s >= 0 && s < kSlices && (slices >> s & 1U) != 0) met |= 1U << b;
  }
  return met;
}

/// Counts, per cell, the poses from which it was seen.
class Sightings {
 public:
  Sightings(const PlanFrame& frame, const ColumnMap& columns, const ObservableOptions& options)
      : frame_(frame),
        columns_(columns),
        rays_(make_rays(options)),
        steps_(make_steps(options)),
        seen_by_(frame.count(), 0),
        last_pose_(frame.count(), 0) {
    for (int b = 0; b < kBeams; ++b) {
      const double slope = beam_slope(options, b);
      if (slope < kGrazing && slope > -kGrazing) grazing_ |= 1U << b;
    }
    for (int s = 0; s < kSlices; ++s) {
      if (s * kSlice_m >= options.band.low_m - 1e-6 && (s + 1) * kSlice_m <= options.band.high_m + 1e-6) {
        band_slices_ |= 1U << s;
      }
    }
  }

  void look_from(int column, int row) {
    ++pose_;
    for (const auto& ray : rays_) {
      std::uint32_t open = ~0U;
      std::uint32_t opaque_before = 0;
      for (const RayCell& cell : ray) {
        const int c = column + cell.dx;
        const int r = row + cell.dy;
        if (!frame_.contains(c, r)) break;
        const BeamStep& step = steps_[static_cast<std::size_t>(cell.step)];
        open &= step.above_floor;
        const std::size_t index = frame_.index(c, r);
        const Column& matter = columns_.at(index);
        if (matter.opaque == 0) {
          if (step.in_range && (open & step.in_band) != 0) count(index);
        } else {
          const std::uint32_t met = matter.opaque == kWholeColumn ? open : open & beams_that_meet(step, matter.opaque);
          if (step.in_range && is_wall(matter) && (met & step.in_band) != 0) {
            // A beam that met nothing at this height one cell before comes from above: on to a table, not to its edge.
            const std::uint32_t from_above =
                opaque_before == 0 ? 0 : grazing_ & beams_that_meet(step, matter.opaque & opaque_before);
            const std::uint32_t black = matter.dark == 0 ? 0 : beams_that_meet(step, matter.dark);
            if ((met & step.in_band & ~from_above & ~black) != 0) count(index);
          } else if (step.in_range && is_free(matter) && (open & ~met & step.in_band) != 0) {
            count(index);
          }
          open &= ~met;
        }
        opaque_before = matter.opaque;
        if (open == 0) break;
      }
    }
  }

  [[nodiscard]] bool is_wall(const Column& matter) const { return (matter.opaque & ~matter.dark & band_slices_) != 0; }
  [[nodiscard]] bool is_free(const Column& matter) const { return (matter.opaque & band_slices_) == 0; }
  [[nodiscard]] int seen_by(std::size_t index) const { return seen_by_[index]; }

 private:
  void count(std::size_t index) {
    if (last_pose_[index] == pose_ || seen_by_[index] == 255) return;
    last_pose_[index] = pose_;
    ++seen_by_[index];
  }

  const PlanFrame& frame_;
  const ColumnMap& columns_;
  std::vector<std::vector<RayCell>> rays_;
  std::vector<BeamStep> steps_;
  std::uint32_t band_slices_ = 0;
  std::uint32_t grazing_ = 0;  ///< beams that are nearly level
  std::uint32_t pose_ = 0;
  std::vector<std::uint8_t> seen_by_;
  std::vector<std::uint32_t> last_pose_;
};

}  // namespace

Result<Observable> find_observable(const World& world, std::span<const PlanarPose> starts,
                                   const ObservableOptions& options) {
  const auto frame = plan_frame(world, options.cell_m);
  if (!frame) return frame.error();
  Observable out;
  out.frame = frame.value();
  const FloorContact floor(world);
  out.reachable = reachable_cells(floor, out.frame, starts, options.reach);
  out.reachable_count = static_cast<std::size_t>(std::count(out.reachable.begin(), out.reachable.end(), 1));

  const ColumnMap columns(world, out.frame);
  Sightings sightings(out.frame, columns, options);
  for (int row = 0; row < out.frame.rows; row += options.lattice_cells) {
    for (int column = 0; column < out.frame.columns; column += options.lattice_cells) {
      if (out.reachable[out.frame.index(column, row)] != 0) sightings.look_from(column, row);
    }
  }

  out.cells.assign(out.frame.count(), SeenCell::not_observable);
  for (int row = 0; row < out.frame.rows; ++row) {
    for (int column = 0; column < out.frame.columns; ++column) {
      const std::size_t index = out.frame.index(column, row);
      if (sightings.seen_by(index) < options.poses_needed) continue;
      if (sightings.is_wall(columns.at(index))) {
        out.cells[index] = SeenCell::wall;
        ++out.wall_count;
      } else if (floor.floor_m(out.frame.x_m(column), out.frame.y_m(row)) > kNoFloor_m) {
        out.cells[index] = SeenCell::free;
        ++out.free_count;
      }
    }
  }
  return out;
}

}  // namespace g3d::hal
