// SPDX-License-Identifier: Apache-2.0
// The long part of a decision, done in pieces: from where the robot stands over the ways, the places and what they
// would show to a tour of views, and to the reasons why the other frontiers are left. The map may change between
// pieces: what was looked at before is looked at again in the next search. One thread; sized by reset().
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "nav/explain.hpp"
#include "nav/explained.hpp"
#include "nav/frontier.hpp"
#include "nav/road_grid.hpp"
#include "nav/set_aside.hpp"
#include "nav/view_gain.hpp"
#include "nav/view_tour.hpp"
#include "nav/viewpoints.hpp"
#include "nav/work_budget.hpp"

namespace g3d::nav {

struct SearchConfig {
  double body_radius_m = 0.18;
  ViewModel view;
  TourConfig tour;  ///< gains in cells of the map
  int max_casts = 400;
  double rich_gains_cells[2] = {150.0, 40.0};  ///< looked at before poorer views
};

/// A view that is being driven to. Its place may have moved when the map has changed: then it is kept no longer.
struct KeptView {
  View view;
  Cell cell;
};

class TourSearch {
 public:
  void reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, const SearchConfig& config);
  void take_changes(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                    std::span<const std::uint32_t> changed);

  /// `allowed`: where views may be. Drops a search that is under way.
  void begin(Cell at, const hal::PlanarPose& robot, const std::optional<KeptView>& kept,
             std::function<bool(const Place&)> allowed);
  /// Until it says true. If nothing else is left, goes to what others have claimed,
  /// and wakes what was set aside.
  [[nodiscard]] bool go_on(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, SetAside& aside,
                           WorkBudget& budget);

  /// Between searches: looks anew from places around which the map has changed, so that the next search need not.
  void work_ahead(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost, WorkBudget& budget);

  // When it has said true:
  [[nodiscard]] std::span<const View> views() const { return tour_.views(); }
  [[nodiscard]] const FrontiersLeft& left() const { return left_; }
  [[nodiscard]] const Place& place(const View& view) const { return places_.place(view.slot); }
  /// Metres from the robot; none if there is no way.
  [[nodiscard]] std::optional<double> way_m(std::uint32_t road) const;
  /// Seconds from the robot to one of the views, turns included.
  [[nodiscard]] double seconds_to(const View& view, const hal::PlanarPose& robot) const {
    return tour_.seconds_to(roads_, from_robot_, robot, from_robot_.reached.front(), view.road, view.heading_rad);
  }

  [[nodiscard]] const FrontierMap& frontiers() const { return frontiers_; }
  [[nodiscard]] const RoadGrid& roads() const { return roads_; }
  [[nodiscard]] const Targets& targets() const { return targets_; }
  [[nodiscard]] const ViewGain& camera() const { return *camera_; }
  /// What looking along a view shows now, ray by ray.
  [[nodiscard]] std::span<const RayGain> look(const CellGrid<CellState>& ground, Cell at, int first_bearing);
  /// The same in all directions. Valid until the next look.
  [[nodiscard]] std::span<const RayGain> look_around(const CellGrid<CellState>& ground, Cell at);

 private:
  enum class Step : std::uint8_t { travelling, refreshing, touring, explaining, done };

  void begin_refresh(const CellGrid<CellState>& ground);
  void begin_tour();
  void begin_explaining();

  SearchConfig config_;
  FrontierMap frontiers_;
  RoadGrid roads_;
  std::unique_ptr<ViewGain> camera_;
  Viewpoints places_;
  Targets targets_;
  ViewTour tour_;
  TravelField from_robot_;
  Explanation explanation_;
  PanoramaGain panorama_;
  std::vector<RayGain> looked_;

  // Of the search that is under way.
  Step step_ = Step::done;
  hal::PlanarPose robot_;
  std::optional<KeptView> kept_;
  std::function<bool(const Place&)> allowed_;
  int level_ = 0;           ///< of richness
  bool is_closer_ = false;  ///< nothing was left to be seen, so it looks closer before it says so
  FrontiersLeft left_;

  bool has_changed_ = false;  ///< since work_ahead() began
  bool is_ahead_ = true;      ///< work_ahead() has come to an end
};

}  // namespace g3d::nav
