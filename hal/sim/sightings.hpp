// SPDX-License-Identifier: Apache-2.0
// What a camera sees of the floor plan from a place, turning all around: ray by ray, the cells that a beam of the
// image's height ends on (walls) or passes (free ones) within the range that it measures. See observable.hpp for what
// counts. The truth that reports and yardsticks compare with; robots never see it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/sim/observable.hpp"

namespace g3d::hal {

class Sightings {
 public:
  /// `world` is read now, `frame` is copied.
  Sightings(const World& world, const PlanFrame& frame, const ObservableOptions& options);

  [[nodiscard]] std::size_t ray_count() const { return rays_.size(); }  ///< evenly around, from x to y
  /// visit(ray, index of the cell), nearest first; cells that two rays meet are visited twice.
  template <typename Visit>
  void look_from(int column, int row, const Visit& visit) const;

  [[nodiscard]] bool is_wall(std::size_t index) const { return is_wall(columns_[index]); }

 private:
  static constexpr int kBeams = 32;  ///< of one column of the image
  static constexpr std::uint32_t kWholeColumn = ~0U;

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

  void add(const Primitive& p);
  void add(const GridWalls& grid);
  void make_rays(const ObservableOptions& options);
  void make_steps(const ObservableOptions& options);
  [[nodiscard]] static std::uint32_t beams_that_meet(const BeamStep& step, std::uint32_t slices);
  [[nodiscard]] bool is_wall(const Column& matter) const { return (matter.opaque & ~matter.dark & band_slices_) != 0; }
  [[nodiscard]] bool is_free(const Column& matter) const { return (matter.opaque & band_slices_) == 0; }

  PlanFrame frame_;
  std::vector<Column> columns_;
  std::vector<std::vector<RayCell>> rays_;  ///< without the cell that they begin in
  std::vector<BeamStep> steps_;             ///< at every whole distance in cells
  std::uint32_t band_slices_ = 0;
  std::uint32_t grazing_ = 0;  ///< beams that are nearly level
};

template <typename Visit>
void Sightings::look_from(int column, int row, const Visit& visit) const {
  for (std::size_t k = 0; k < rays_.size(); ++k) {
    std::uint32_t open = ~0U;
    std::uint32_t opaque_before = 0;
    for (const RayCell& cell : rays_[k]) {
      const int c = column + cell.dx;
      const int r = row + cell.dy;
      if (!frame_.contains(c, r)) break;
      const BeamStep& step = steps_[static_cast<std::size_t>(cell.step)];
      open &= step.above_floor;
      const std::size_t index = frame_.index(c, r);
      const Column& matter = columns_[index];
      if (matter.opaque == 0) {
        if (step.in_range && (open & step.in_band) != 0) visit(k, index);
      } else {
        const std::uint32_t met = matter.opaque == kWholeColumn ? open : open & beams_that_meet(step, matter.opaque);
        if (step.in_range && is_wall(matter) && (met & step.in_band) != 0) {
          // A beam that met nothing at this height one cell before comes from above: on to a table, not to its edge.
          const std::uint32_t from_above =
              opaque_before == 0 ? 0 : grazing_ & beams_that_meet(step, matter.opaque & opaque_before);
          const std::uint32_t black = matter.dark == 0 ? 0 : beams_that_meet(step, matter.dark);
          if ((met & step.in_band & ~from_above & ~black) != 0) visit(k, index);
        } else if (step.in_range && is_free(matter) && (open & ~met & step.in_band) != 0) {
          visit(k, index);
        }
        open &= ~met;
      }
      opaque_before = matter.opaque;
      if (open == 0) break;
    }
  }
}

}  // namespace g3d::hal
