// SPDX-License-Identifier: Apache-2.0
#include "nav/explorer.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "nav/explain.hpp"
#include "nav/frontier.hpp"
#include "nav/road_grid.hpp"
#include "nav/set_aside.hpp"
#include "nav/view_gain.hpp"
#include "nav/view_tour.hpp"
#include "nav/viewpoints.hpp"

namespace g3d::nav {
namespace {

constexpr TimeNs kReplanPeriod_ns = 1'000'000'000;
constexpr double kHope_m = 0.8;
constexpr double kDropShare = 0.2;        ///< a goal that promises less than this of what it did is dropped
constexpr std::size_t kFewChanges = 300;  ///< cells; with fewer, a plan is kept for up to kKeepPlan_ns
constexpr TimeNs kKeepPlan_ns = 10'000'000'000;
constexpr double kRichViews_cells[] = {150.0, 40.0};  ///< of 5 cm: looked at before poorer ones
constexpr double kGainPerDrive_cellps = 0.3;          ///< cells of 5 cm that a second of driving must show at least
constexpr double kTurnAround_rad = 6.283185307179586;
constexpr double kSamePlace_m = 0.3;
constexpr double kPatience_s = 30.0;
constexpr double kPatienceFactor = 4.0;

}  // namespace

struct Explorer::State {
  explicit State(const ExplorerConfig& c) : config(c) {}

  struct Goal {
    bool active = false;
    Cell cell;
    View view;
    TimeNs deadline = 0;  ///< whoever drives should have said something by then
  };
  enum class Stage : std::uint8_t { start, looking_around, exploring, going_home, at_home };

  void reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost);
  void take_changes(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                    std::span<const std::uint32_t> changed);
  [[nodiscard]] bool in_area(double x_m, double y_m) const;
  [[nodiscard]] bool goal_still_pays(const CellGrid<CellState>& ground);
  void note_fruitless(const CellGrid<CellState>& ground, TimeNs now);
  void note_blocked(const CellGrid<CellState>& ground, TimeNs now);
  [[nodiscard]] std::span<const View> plan(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                           const PlanarPose& robot);
  [[nodiscard]] Decision goal_decision(const CellGrid<CellState>& ground, bool is_new) const;
  [[nodiscard]] Decision home_decision(const PlanarPose& robot);
  void turn_home();
  [[nodiscard]] bool needs_energy_for_home(const CellGrid<CellState>& ground) const;

  ExplorerConfig config;
  int columns = 0;
  int rows = 0;
  double origin_x_m = 0.0;
  double origin_y_m = 0.0;
  double min_gain_cells = 6.0;
  FrontierMap frontiers;
  RoadGrid roads;
  std::unique_ptr<ViewGain> camera;
  Viewpoints places;
  Targets targets;
  ViewTour tour;
  SetAside aside;
  TravelField from_robot;
  Explanation explanation;
  PanoramaGain panorama;

  Stage stage = Stage::start;
  bool has_home = false;
  PlanarPose home;
  double energy_left_s = std::numeric_limits<double>::infinity();
  Goal goal;
  bool reached = false;
  bool failed = false;
  GoalFailure failure = GoalFailure::no_path;
  TimeNs planned_at = 0;
  std::size_t changes = 0;
  bool homeward_is_new = false;
  std::uint32_t home_failures = 0;
  FrontiersLeft left;
};

void Explorer::State::reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost) {
  columns = ground.columns;
  rows = ground.rows;
  origin_x_m = ground.origin_x_m;
  origin_y_m = ground.origin_y_m;
  const double area = ground.resolution_m * ground.resolution_m / (0.05 * 0.05);
  min_gain_cells = config.min_gain_cells / area;
  const ViewModel model{config.near_m, config.far_m, config.view_rad, config.camera_forward_m, kHope_m};
  camera = std::make_unique<ViewGain>(model, ground.resolution_m);
  frontiers.reset(ground);
  roads.reset(cost, config.body_radius_m);
  roads.size_field(from_robot);
  places.reset(ground, roads);
  targets.reset(columns, rows);
  aside.reset(targets.size(), config.max_tries, config.set_aside_s);
  for (std::uint32_t i = 0; i < ground.cells.size(); ++i) {
    const Cell c = ground.cell(i);
    if (!in_area(ground.centre_x_m(c), ground.centre_y_m(c))) aside.exclude(targets.of_cell(i));
  }
  TourConfig t;
  t.speed_mps = config.speed_mps;
  t.turn_radps = config.turn_radps;
  t.min_gain_cells = min_gain_cells;
  t.gain_per_drive_s = kGainPerDrive_cellps / area;
  tour.reset(roads, targets, t, camera->window());
  explanation.reset(targets.size());
  goal.active = false;
}

void Explorer::State::take_changes(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                   std::span<const std::uint32_t> changed) {
  if (ground.columns != columns || ground.rows != rows || ground.origin_x_m != origin_x_m ||
      ground.origin_y_m != origin_y_m) {
    reset(ground, cost);
    return;
  }
  frontiers.update(ground, changed);
  roads.update(cost, changed);
  places.note_changes(changed);
}

bool Explorer::State::in_area(double x_m, double y_m) const {
  if (config.area_max_x_m <= config.area_min_x_m || config.area_max_y_m <= config.area_min_y_m) return true;
  return x_m >= config.area_min_x_m && x_m <= config.area_max_x_m && y_m >= config.area_min_y_m &&
         y_m <= config.area_max_y_m;
}

bool Explorer::State::goal_still_pays(const CellGrid<CellState>& ground) {
  camera->look(ground, goal.cell, panorama);
  const double gain = tour.gain_of(panorama, goal.view.first_bearing, targets, aside.ignored());
  return gain >= std::max(min_gain_cells, kDropShare * static_cast<double>(goal.view.gain_cells));
}

/// It stood there and looked: what it was promised to see and did not, it will not see from there.
void Explorer::State::note_fruitless(const CellGrid<CellState>& ground, TimeNs now) {
  const double promised = static_cast<double>(goal.view.gain_cells) * config.min_gain_cells / min_gain_cells;
  const int weight = promised < kRichViews_cells[1] ? config.max_tries : 1;
  camera->look(ground, goal.cell, panorama);
  for (int k = 0; k < camera->window() * kRaysPerBearing; ++k) {
    const RayGain& ray =
        panorama[static_cast<std::size_t>((goal.view.first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry != RayGain::kNothing) {
      aside.target_failed(targets.of_cell(ray.entry), SetAside::Cause::fruitless, now, weight);
    }
  }
}

void Explorer::State::note_blocked(const CellGrid<CellState>& ground, TimeNs now) {
  aside.place_failed(goal.cell, now);
  camera->look(ground, goal.cell, panorama);
  for (int k = 0; k < camera->window() * kRaysPerBearing; ++k) {
    const RayGain& ray =
        panorama[static_cast<std::size_t>((goal.view.first_bearing * kRaysPerBearing + k) % kViewRays)];
    if (ray.entry != RayGain::kNothing) {
      aside.target_failed(targets.of_cell(ray.entry), SetAside::Cause::blocked, now);
    }
  }
}

std::span<const View> Explorer::State::plan(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                            const PlanarPose& robot) {
  const int near_cells = static_cast<int>(kSamePlace_m / ground.resolution_m);
  const double scale = min_gain_cells / config.min_gain_cells;
  const auto allowed = [&](const Place& place) {
    return in_area(ground.centre_x_m(place.cell), ground.centre_y_m(place.cell)) &&
           !aside.is_place_resting(place.cell, near_cells);
  };
  for (;;) {
    const bool complete =
        places.refresh(ground, cost, roads, from_robot, frontiers, *camera, config.max_views_per_decision);
    const bool keep = goal.active && places.place(goal.view.slot).cell == goal.cell;
    tour.keep(keep ? &goal.view : nullptr);
    // What is rich first, so that the tour is not drawn into every corner; then what is left.
    for (const double least : {kRichViews_cells[0] * scale, kRichViews_cells[1] * scale, min_gain_cells}) {
      tour.set_min_gain(std::max(least, min_gain_cells));
      const std::span<const View> views =
          tour.plan(places, roads, from_robot, robot, targets, aside.ignored(), std::ref(allowed));
      if (!views.empty()) return views;
    }
    if (complete) return {};
  }
}

bool Explorer::State::needs_energy_for_home(const CellGrid<CellState>& ground) const {
  const Cell c = ground.cell_of(home.x_m, home.y_m);
  if (!ground.contains(c)) return false;
  const std::int32_t tenths = from_robot.distance[roads.road_of(c)];
  const double way_s = tenths == TravelField::kNever ? 0.0 : tenths * roads.step_m() / 10 / config.speed_mps;
  return energy_left_s < config.home_reserve_factor * way_s + config.home_reserve_s;
}

Decision Explorer::State::goal_decision(const CellGrid<CellState>& ground, bool is_new) const {
  Decision d;
  d.kind = DecisionKind::goal;
  d.goal = {ground.centre_x_m(goal.cell), ground.centre_y_m(goal.cell), goal.view.heading_rad};
  d.is_new = is_new;
  d.expected_cells = static_cast<double>(goal.view.gain_cells);
  d.left = left;
  return d;
}

Decision Explorer::State::home_decision(const PlanarPose& robot) {
  Decision d;
  d.left = left;
  d.is_new = homeward_is_new;
  d.goal = home;
  const bool there = std::hypot(robot.x_m - home.x_m, robot.y_m - home.y_m) < 0.15;
  if (reached || (stage == Stage::going_home && there && homeward_is_new) || home_failures >= 3) stage = Stage::at_home;
  d.kind = stage == Stage::at_home ? DecisionKind::done : DecisionKind::go_home;
  reached = homeward_is_new = false;
  return d;
}

void Explorer::State::turn_home() {
  stage = Stage::going_home;
  homeward_is_new = true;
  goal.active = reached = failed = false;
}

Explorer::Explorer(const ExplorerConfig& config) : state_(std::make_unique<State>(config)) {}
Explorer::~Explorer() = default;

std::unique_ptr<GoalChooser> make_explorer(const ExplorerConfig& config) { return std::make_unique<Explorer>(config); }

Decision Explorer::decide(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                          std::span<const std::uint32_t> changed_cells, const PlanarPose& T_world_base, TimeNs now) {
  State& s = *state_;
  s.take_changes(ground, cost, changed_cells);
  if (!s.has_home) set_home(T_world_base);
  if (s.stage == State::Stage::start) {
    s.stage = s.config.look_around_first ? State::Stage::looking_around : State::Stage::exploring;
    if (s.config.look_around_first) {
      Decision d;
      d.kind = DecisionKind::look_around;
      d.goal = T_world_base;
      d.turn_rad = kTurnAround_rad;
      d.is_new = true;
      return d;
    }
  }
  if (s.stage == State::Stage::looking_around) {
    if (!s.reached && !s.failed) {
      Decision d;
      d.kind = DecisionKind::look_around;
      d.goal = T_world_base;
      d.turn_rad = kTurnAround_rad;
      return d;
    }
    s.stage = State::Stage::exploring;
    s.reached = s.failed = false;
  }
  if (s.stage == State::Stage::going_home || s.stage == State::Stage::at_home) {
    if (s.failed) {
      ++s.home_failures;
      s.homeward_is_new = true;
    }
    s.failed = false;
    return s.home_decision(T_world_base);
  }

  s.aside.expire(now);
  if (s.goal.active && !s.reached && now > s.goal.deadline) s.failed = true;
  if (s.goal.active && s.reached) s.note_fruitless(ground, now);
  if (s.goal.active && s.failed) s.note_blocked(ground, now);
  if (s.reached || s.failed) s.goal.active = false;
  s.reached = s.failed = false;
  const bool pays = s.goal.active && s.goal_still_pays(ground);
  s.changes += changed_cells.size();
  const bool little_new = s.changes < kFewChanges && now - s.planned_at < kKeepPlan_ns;
  if (pays && (now - s.planned_at < kReplanPeriod_ns || little_new)) return s.goal_decision(ground, false);
  s.changes = 0;
  s.goal.active = pays;

  s.planned_at = now;
  const Cell at = ground.cell_of(T_world_base.x_m, T_world_base.y_m);
  if (!ground.contains(at)) {
    s.turn_home();
    return s.home_decision(T_world_base);
  }
  s.roads.travel(s.roads.road_of(at), TravelField::kNever - 100, s.from_robot);
  std::span<const View> views = s.plan(ground, cost, T_world_base);
  if (views.empty() && s.aside.wake_all()) views = s.plan(ground, cost, T_world_base);
  s.frontiers.make_clusters();
  s.left = s.explanation.explain(ground, s.frontiers, s.targets, s.aside, s.places, s.config.near_m, !views.empty());
  const bool low = s.needs_energy_for_home(ground);
  if (low || views.empty()) {
    if (low) s.left[LeftReason::energy] += s.left.open;
    s.left.open = 0;
    s.turn_home();
    return s.home_decision(T_world_base);
  }

  const View& first = views.front();
  const Place& place = s.places.place(first.slot);
  const bool same = s.goal.active && s.goal.cell == place.cell &&
                    std::abs(std::remainder(first.heading_rad - s.goal.view.heading_rad, kTurnAround_rad)) < 0.3;
  if (same && pays) return s.goal_decision(ground, false);
  const double way_s = s.from_robot.distance[place.road] * s.roads.step_m() / 10 / s.config.speed_mps;
  s.goal = {true, place.cell, first, now + static_cast<TimeNs>((kPatience_s + kPatienceFactor * way_s) * 1e9)};
  return s.goal_decision(ground, true);
}

void Explorer::goal_reached() { state_->reached = true; }

void Explorer::goal_failed(GoalFailure reason) {
  state_->failed = true;
  state_->failure = reason;
}

void Explorer::set_home(const PlanarPose& T_world_home) {
  state_->home = T_world_home;
  state_->has_home = true;
}

void Explorer::set_energy_left(double seconds) { state_->energy_left_s = seconds; }

void Explorer::return_home(bool for_energy) {
  if (for_energy) state_->left[LeftReason::energy] += std::exchange(state_->left.open, 0);
  if (state_->stage != State::Stage::going_home && state_->stage != State::Stage::at_home) state_->turn_home();
}

std::span<const std::uint32_t> Explorer::frontier_cells() const { return state_->frontiers.cells(); }

}  // namespace g3d::nav
