// SPDX-License-Identifier: Apache-2.0
// Which views to take, and in which order. A view is a place and a heading. Views are chosen so that together they show
// every frontier (greedy set cover), then ordered so that what they show is seen early and the whole tour is short, and
// the first one moved to where it costs least. One thread; no allocation after the first calls.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "hal/twist.hpp"
#include "nav/road_grid.hpp"
#include "nav/viewpoints.hpp"
#include "nav/visit_order.hpp"
#include "nav/work_budget.hpp"

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

/// What a tour is planned in. All of it must outlive the planning; the map may change meanwhile.
struct TourScene {
  const Viewpoints& places;
  RoadGrid& roads;
  const TravelField& from_robot;
  hal::PlanarPose robot;
  const Targets& targets;
  std::span<const std::uint8_t> ignored;             ///< per target, nonzero for those that are not to be looked at
  const std::function<bool(const Place&)>& allowed;  ///< where it may go
};

class ViewTour {
 public:
  void reset(const RoadGrid& roads, const Targets& targets, const TourConfig& config, int window);
  /// The view that is being driven to, so that it is not given up for little.
  void keep(const std::optional<View>& view) { kept_ = view; }
  void set_min_gain(double cells) { config_.min_gain_cells = cells; }

  /// The tour, its first view first; empty if nothing is worth a look.
  std::span<const View> plan(const TourScene& scene);
  /// The same in pieces: go_on() until it says true.
  void begin();
  [[nodiscard]] bool go_on(const TourScene& scene, WorkBudget& budget);
  [[nodiscard]] std::span<const View> views() const { return tour_; }

  /// Cells that the view would show, of targets that are not ignored.
  [[nodiscard]] double gain_of(const PanoramaGain& gain, int first_bearing, const Targets& targets,
                               std::span<const std::uint8_t> ignored) const;
  /// Seconds from the robot to a view, turns included.
  [[nodiscard]] double seconds_to(const RoadGrid& roads, const TravelField& from_robot, const hal::PlanarPose& robot,
                                  std::uint32_t from_road, std::uint32_t to_road, double heading_rad) const;

 private:
  enum class Phase : std::uint8_t { rating, choosing, measuring, ordering, reaching_second, refining, done };
  struct Candidate {
    float score = 0.0F;
    std::uint32_t index = 0;
  };
  struct Best {
    float gain = 0.0F;
    int first_bearing = 0;
  };
  /// What moving the first view is judged by.
  struct Refining {
    View first;  ///< as it was chosen
    double task_cells = 0.0;
    double worth_s = 0.0;  ///< of a cell
    double best = 0.0;
  };

  [[nodiscard]] static bool is_worse(const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score < b.score : a.index > b.index;
  }
  void enter(Phase phase);
  [[nodiscard]] Best best_window(const Place& place, const Targets& targets,
                                 std::span<const std::uint8_t> ignored) const;
  [[nodiscard]] double least_cells(const TourScene& scene, const Place& place) const;
  [[nodiscard]] float score(const TourScene& scene, const Place& place, float gain) const;
  void take(const Viewpoints& places, const Targets& targets, std::uint32_t slot, const Best& best);
  void take_kept(const TourScene& scene);
  [[nodiscard]] bool rate(const TourScene& scene, WorkBudget& budget);
  [[nodiscard]] bool choose(const TourScene& scene, WorkBudget& budget);
  [[nodiscard]] bool measure(const TourScene& scene, WorkBudget& budget);
  void begin_refining(const TourScene& scene);
  [[nodiscard]] bool refine(const TourScene& scene, WorkBudget& budget);
  void try_first(const TourScene& scene, std::uint32_t slot);

  TourConfig config_;
  std::optional<View> kept_;
  bool has_kept_ = false;  ///< views_[0] is the kept one
  int window_ = 11;
  std::vector<std::uint32_t> covered_in_;  ///< per target
  std::uint32_t round_ = 0;
  Phase phase_ = Phase::done;
  std::size_t next_ = 0;  ///< of the phase
  bool is_first_ = true;  ///< of the phase
  std::vector<Candidate> heap_;
  std::vector<View> views_;
  std::vector<View> tour_;
  VisitOrder order_;
  Refining refining_;
  TravelField field_;
};

}  // namespace g3d::nav
