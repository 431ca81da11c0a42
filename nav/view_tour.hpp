// SPDX-License-Identifier: Apache-2.0
// Which views to take, and in which order. A view is a place and a heading. Views are chosen so that together they show
// every frontier (greedy set cover), then ordered (insertion, or-opt, 2-opt) so that what they show is seen early and
// the whole tour is short. One thread; no allocation after the first calls.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/twist.hpp"
#include "nav/road_grid.hpp"
#include "nav/viewpoints.hpp"

namespace g3d::nav {

struct TourConfig {
  double speed_mps = 0.4;
  double turn_radps = 1.0;
  double min_gain_cells = 6.0;
  double gain_per_drive_s = 0.3;  ///< more cells that a view must show for each second of the drive to it
  double stop_s = 1.0;            ///< what a stop costs beyond driving and turning
  double length_weight = 0.3;     ///< of the tour's whole time, against the mean time at which a cell is seen
  double near_s = 8.0;            ///< the smaller, the more the cover prefers near places over rich ones
  double keep_s = 6.0;            ///< how much better another first view must be than the one that is being driven to
  double task_share = 0.6;        ///< of what it was chosen for, the first view must show when it is moved
  int max_views = 24;
  int passes = 6;
};

struct View {
  std::uint32_t slot = 0;  ///< of the place
  std::uint32_t road = 0;
  int first_bearing = 0;
  double heading_rad = 0.0;
  float gain_cells = 0.0F;  ///< what it shows beyond the views chosen before it
};

/// Frontier cells are told apart by the square of 4 x 4 cells that they lie in.
class Targets {
 public:
  void reset(int columns, int rows);
  [[nodiscard]] std::uint32_t of_cell(std::uint32_t cell) const {
    const std::uint32_t x = cell % columns_;
    const std::uint32_t y = cell / columns_;
    return y / 4 * target_columns_ + x / 4;
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::uint32_t columns_ = 1;
  std::uint32_t target_columns_ = 1;
  std::size_t size_ = 0;
};

class ViewTour {
 public:
  void reset(const RoadGrid& roads, const Targets& targets, const TourConfig& config, int window);
  /// The view that is being driven to, so that it is not given up for little; none: nullptr.
  void keep(const View* view) { kept_ = view; }
  void set_min_gain(double cells) { config_.min_gain_cells = cells; }

  /// `ignored`: per target, nonzero for those that are not to be looked at. `allowed(place)`: where it may go.
  /// Returns the tour, its first view first; empty if nothing is worth a look.
  std::span<const View> plan(const Viewpoints& places, RoadGrid& roads, const TravelField& from_robot,
                             const hal::PlanarPose& robot, const Targets& targets,
                             std::span<const std::uint8_t> ignored, const std::function<bool(const Place&)>& allowed);

  /// Cells that the view would show, of targets that are not ignored.
  [[nodiscard]] double gain_of(const PanoramaGain& gain, int first_bearing, const Targets& targets,
                               std::span<const std::uint8_t> ignored) const;
  /// Seconds from the robot to a view, turns included.
  [[nodiscard]] double seconds_to(const RoadGrid& roads, const TravelField& from_robot, const hal::PlanarPose& robot,
                                  std::uint32_t from_road, std::uint32_t to_road, double heading_rad) const;

 private:
  struct Candidate {
    float score = 0.0F;
    std::uint32_t index = 0;
  };
  struct Best {
    float gain = 0.0F;
    int first_bearing = 0;
  };

  [[nodiscard]] Best best_window(const Place& place, const Targets& targets,
                                 std::span<const std::uint8_t> ignored) const;
  void choose(const Viewpoints& places, const TravelField& from_robot, const RoadGrid& roads, const Targets& targets,
              std::span<const std::uint8_t> ignored, const std::function<bool(const Place&)>& allowed);
  void measure(RoadGrid& roads, const TravelField& from_robot, const hal::PlanarPose& robot);
  void order();
  void refine_first(const Viewpoints& places, RoadGrid& roads, const TravelField& from_robot,
                    const hal::PlanarPose& robot, const Targets& targets, std::span<const std::uint8_t> ignored,
                    const std::function<bool(const Place&)>& allowed);
  [[nodiscard]] double price(std::span<const std::uint16_t> order) const;

  void take(const Viewpoints& places, const Targets& targets, std::uint32_t slot, const Best& best);

  TourConfig config_;
  const View* kept_ = nullptr;
  bool has_kept_ = false;  ///< views_[0] is the kept one
  int window_ = 11;
  std::vector<std::uint32_t> covered_in_;  ///< per target
  std::uint32_t round_ = 0;
  std::vector<Candidate> heap_;
  std::vector<View> views_;
  std::vector<View> tour_;
  std::vector<float> seconds_;  ///< from view i (0: the robot) to view j, (views + 1) squared
  std::vector<std::uint16_t> order_;
  std::vector<std::uint16_t> trial_;
  TravelField field_;
};

}  // namespace g3d::nav
