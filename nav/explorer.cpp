// SPDX-License-Identifier: Apache-2.0
#include "nav/explorer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "nav/decisions.hpp"
#include "nav/glances.hpp"
#include "nav/set_aside.hpp"
#include "nav/team_claims.hpp"
#include "nav/tour_search.hpp"

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
constexpr int kGlancesPerLook = 2;  ///< so many glances on the way in vain count like one look of its own
constexpr double kAllInVain = 0.9;  ///< of what a look was to show is still hidden
constexpr double kSamePlace_m = 0.3;
constexpr double kPatience_s = 30.0;
constexpr TimeNs kTurnBackPeriod_ns = 5'000'000'000;
constexpr double kPatienceFactor = 4.0;

}  // namespace

struct Explorer::State {
  explicit State(const ExplorerConfig& c) : config(c) {}

  struct Goal {
    bool active = false;
    Cell cell;
    View view;
    bool is_shared = false;  ///< nothing was left but what teammates claim
    TimeNs deadline = 0;     ///< whoever drives should have said something by then
  };
  enum class Stage : std::uint8_t { start, looking_around, exploring, going_home, at_home };

  void reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost);
  void reset_aside(const CellGrid<CellState>& ground);
  [[nodiscard]] bool has_geometry_of(const CellGrid<CellState>& ground) const;
  [[nodiscard]] bool in_area(double x_m, double y_m) const;
  [[nodiscard]] bool goal_still_pays(const CellGrid<CellState>& ground);
  void respect_team(const CellGrid<CellState>& ground);
  [[nodiscard]] bool may_turn_back(TimeNs now) const;
  void note_goal_is_over(const CellGrid<CellState>& ground, TimeNs now);
  void note_fruitless(const CellGrid<CellState>& ground, TimeNs now);
  void note_blocked(const CellGrid<CellState>& ground, TimeNs now);
  [[nodiscard]] std::optional<Decision> begin_search(const CellGrid<CellState>& ground, const PlanarPose& robot,
                                                     TimeNs now);
  [[nodiscard]] Decision take_tour(const CellGrid<CellState>& ground, const PlanarPose& robot, TimeNs now);
  [[nodiscard]] Decision goal_decision(const CellGrid<CellState>& ground, bool is_new) const;
  [[nodiscard]] Decision home_decision(const PlanarPose& robot);
  void turn_home();
  [[nodiscard]] bool needs_energy_for_home(const CellGrid<CellState>& ground) const;

  ExplorerConfig config;
  int columns = 0;
  int rows = 0;
  double origin_x_m = 0.0;
  double origin_y_m = 0.0;
  double resolution_m = 0.05;
  double min_gain_cells = 6.0;
  TourSearch search;
  SetAside aside;
  Glances glances;
  TeamClaims claims;
  TourOffers offers;

  Stage stage = Stage::start;
  bool has_home = false;
  PlanarPose home;
  double energy_left_s = std::numeric_limits<double>::infinity();
  Goal goal;
  bool is_searching = false;
  bool goal_pays = false;  ///< as of the beginning of the search
  bool reached = false;
  bool failed = false;
  TimeNs planned_at = 0;
  std::size_t changes = 0;
  bool homeward_is_new = false;
  bool is_called_home = false;  ///< somebody has said so, or the battery
  std::uint32_t home_failures = 0;
  FrontiersLeft left;
};

void Explorer::State::reset(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost) {
  columns = ground.columns;
  rows = ground.rows;
  origin_x_m = ground.origin_x_m;
  origin_y_m = ground.origin_y_m;
  resolution_m = ground.resolution_m;
  const double area = ground.resolution_m * ground.resolution_m / (0.05 * 0.05);
  min_gain_cells = config.min_gain_cells / area;
  SearchConfig c;
  c.body_radius_m = config.body_radius_m;
  c.view = {config.near_m, config.far_m, config.view_rad, config.camera_forward_m, kHope_m};
  c.tour.speed_mps = config.speed_mps;
  c.tour.turn_radps = config.turn_radps;
  c.tour.min_gain_cells = min_gain_cells;
  c.tour.gain_per_drive_s = kGainPerDrive_cellps / area;
  c.max_casts = config.max_views_per_decision;
  const double scale = min_gain_cells / config.min_gain_cells;
  for (std::size_t i = 0; i < std::size(kRichViews_cells); ++i) c.rich_gains_cells[i] = kRichViews_cells[i] * scale;
  search.reset(ground, cost, c);
  reset_aside(ground);
  goal.active = is_searching = false;
}

void Explorer::State::reset_aside(const CellGrid<CellState>& ground) {
  const Targets& targets = search.targets();
  aside.reset(targets.size(), config.max_tries, config.set_aside_s);
  glances.reset(targets);
  if (config.area_max_x_m <= config.area_min_x_m || config.area_max_y_m <= config.area_min_y_m) return;
  for (std::uint32_t i = 0; i < ground.cells.size(); ++i) {
    const Cell c = ground.cell(i);
    if (!in_area(ground.centre_x_m(c), ground.centre_y_m(c))) aside.exclude(targets.of_cell(i));
  }
}

bool Explorer::State::has_geometry_of(const CellGrid<CellState>& ground) const {
  return ground.columns == columns && ground.rows == rows && ground.origin_x_m == origin_x_m &&
         ground.origin_y_m == origin_y_m;
}

bool Explorer::State::in_area(double x_m, double y_m) const {
  if (config.area_max_x_m <= config.area_min_x_m || config.area_max_y_m <= config.area_min_y_m) return true;
  return x_m >= config.area_min_x_m && x_m <= config.area_max_x_m && y_m >= config.area_min_y_m &&
         y_m <= config.area_max_y_m;
}

bool Explorer::State::goal_still_pays(const CellGrid<CellState>& ground) {
  double gain = 0.0;
  for (const RayGain& ray : search.look(ground, goal.cell, goal.view.first_bearing)) {
    if (ray.entry == RayGain::kNothing || aside.ignored()[search.targets().of_cell(ray.entry)] != 0) continue;
    gain += static_cast<double>(ray.cells);
  }
  return gain >= std::max(min_gain_cells, kDropShare * static_cast<double>(goal.view.gain_cells));
}

/// What teammates claim is theirs. A goal that they have come to claim as well is given up, if they go before.
void Explorer::State::respect_team(const CellGrid<CellState>& ground) {
  std::optional<TeamClaims::Own> own;
  if (goal.active) own = {goal.cell, goal.view.first_bearing};
  claims.mark(ground, search, aside, own);
  if (goal.active && goal.is_shared) aside.forget_claims();  // until the search
  if (goal.active && claims.is_lost(ground.centre_x_m(goal.cell), ground.centre_y_m(goal.cell))) goal.active = false;
}

/// On the way home because nothing was left to do; but teammates have seen more since.
bool Explorer::State::may_turn_back(TimeNs now) const {
  return stage == Stage::going_home && claims.has_team() && !is_called_home && changes >= kFewChanges &&
         now - planned_at >= kTurnBackPeriod_ns;
}

/// It stood there and looked: what it was promised to see and did not, it will not see from there, and hardly from
/// elsewhere if it was glanced at from several places before.
void Explorer::State::note_fruitless(const CellGrid<CellState>& ground, TimeNs now) {
  const double promised = static_cast<double>(goal.view.gain_cells) * config.min_gain_cells / min_gain_cells;
  double still_cells = 0.0;
  for (const RayGain& ray : search.look(ground, goal.cell, goal.view.first_bearing)) {
    still_cells += static_cast<double>(ray.cells);
  }
  // A look that has shown nothing at all would show nothing a second time.
  const bool all_in_vain = still_cells >= kAllInVain * static_cast<double>(goal.view.gain_cells);
  const int least_weight = promised < kRichViews_cells[1] ? config.max_tries : all_in_vain ? 2 : 1;
  for (const RayGain& ray : search.look(ground, goal.cell, goal.view.first_bearing)) {
    if (ray.entry == RayGain::kNothing) continue;
    const std::uint32_t target = search.targets().of_cell(ray.entry);
    const int weight = std::max(least_weight, 1 + glances.count(target) / kGlancesPerLook);
    aside.target_failed(target, SetAside::Cause::fruitless, now, weight);
  }
}

void Explorer::State::note_blocked(const CellGrid<CellState>& ground, TimeNs now) {
  aside.place_failed(goal.cell, now);
  for (const RayGain& ray : search.look(ground, goal.cell, goal.view.first_bearing)) {
    if (ray.entry == RayGain::kNothing) continue;
    aside.target_failed(search.targets().of_cell(ray.entry), SetAside::Cause::blocked, now);
  }
}

void Explorer::State::note_goal_is_over(const CellGrid<CellState>& ground, TimeNs now) {
  if (goal.active && reached) note_fruitless(ground, now);
  if (goal.active && failed) note_blocked(ground, now);
  if (reached || failed) goal.active = false;
  reached = failed = false;
}

bool Explorer::State::needs_energy_for_home(const CellGrid<CellState>& ground) const {
  const Cell c = ground.cell_of(home.x_m, home.y_m);
  if (!ground.contains(c)) return false;
  const double way_s = search.way_m(search.roads().road_of(c)).value_or(0.0) / config.speed_mps;
  return energy_left_s < config.home_reserve_factor * way_s + config.home_reserve_s;
}

Decision Explorer::State::goal_decision(const CellGrid<CellState>& ground, bool is_new) const {
  return drive_to({ground.centre_x_m(goal.cell), ground.centre_y_m(goal.cell), goal.view.heading_rad},
                  static_cast<double>(goal.view.gain_cells), left, is_new);
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
  goal.active = reached = failed = is_searching = false;
}

/// A decision at once if the goal stays as it is, or if there is nothing to search for.
std::optional<Decision> Explorer::State::begin_search(const CellGrid<CellState>& ground, const PlanarPose& robot,
                                                      TimeNs now) {
  aside.expire(now);
  glances.look(ground, search.targets(), search.camera(), robot, now);
  if (goal.active && !reached && now > goal.deadline) failed = true;
  note_goal_is_over(ground, now);
  if (claims.has_team() || aside.has_claims()) respect_team(ground);
  goal_pays = goal.active && goal_still_pays(ground);
  const bool is_sent_elsewhere =
      goal_pays && claims.wants_other_than(ground.centre_x_m(goal.cell), ground.centre_y_m(goal.cell));
  const bool little_new = changes < kFewChanges && now - planned_at < kKeepPlan_ns && !is_sent_elsewhere;
  if (goal_pays && (now - planned_at < kReplanPeriod_ns || little_new)) return goal_decision(ground, false);
  changes = 0;
  goal.active = goal_pays;
  planned_at = now;
  const Cell at = ground.cell_of(robot.x_m, robot.y_m);
  if (!ground.contains(at)) {
    turn_home();
    return home_decision(robot);
  }
  const auto allowed = [this](const Place& place) {
    return in_area(origin_x_m + (place.cell.x + 0.5) * resolution_m,
                   origin_y_m + (place.cell.y + 0.5) * resolution_m) &&
           !aside.is_place_resting(place.cell, static_cast<int>(kSamePlace_m / resolution_m)) &&
           !claims.is_claimed(origin_x_m + (place.cell.x + 0.5) * resolution_m,
                              origin_y_m + (place.cell.y + 0.5) * resolution_m);
  };
  if (goal.active && goal.is_shared) claims.mark(ground, search, aside, std::nullopt);
  search.begin(at, robot, goal.active ? std::optional(KeptView{goal.view, goal.cell}) : std::nullopt, allowed);
  is_searching = true;
  return std::nullopt;
}

Decision Explorer::State::take_tour(const CellGrid<CellState>& ground, const PlanarPose& robot, TimeNs now) {
  is_searching = false;
  left = search.left();
  const std::span<const View> views = search.views();
  const bool low = needs_energy_for_home(ground);
  offers.count = 0;
  if (low || views.empty()) {
    is_called_home = is_called_home || low;
    if (low) left[LeftReason::energy] += left.open;
    left.open = 0;
    turn_home();
    return home_decision(robot);
  }
  offers.take(ground, search, robot);
  const View* const sent_to = claims.assigned(ground, search, views);
  const View& first = sent_to != nullptr ? *sent_to : views.front();
  const Place& place = search.place(first);
  const bool same = goal.active && goal.cell == place.cell &&
                    std::abs(std::remainder(first.heading_rad - goal.view.heading_rad, kTurnAround_rad)) < 0.3;
  if (same && goal_pays) return goal_decision(ground, false);
  const double way_s = search.way_m(place.road).value_or(0.0) / config.speed_mps;
  const bool is_shared = claims.size() > 0 && !aside.has_claims();
  goal = {true, place.cell, first, is_shared, now + static_cast<TimeNs>((kPatience_s + kPatienceFactor * way_s) * 1e9)};
  return goal_decision(ground, true);
}

Explorer::Explorer(const ExplorerConfig& config) : state_(std::make_unique<State>(config)) {}
Explorer::~Explorer() = default;

std::unique_ptr<GoalChooser> make_explorer(const ExplorerConfig& config) { return std::make_unique<Explorer>(config); }

void Explorer::prepare(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost) {
  state_->reset(ground, cost);
}

std::optional<Decision> Explorer::decide(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                                         std::span<const std::uint32_t> changed_cells, const PlanarPose& T_world_base,
                                         TimeNs now) {
  State& s = *state_;
  if (s.has_geometry_of(ground)) {
    s.search.take_changes(ground, cost, changed_cells);
  } else {
    s.reset(ground, cost);
  }
  s.changes += changed_cells.size();
  if (!s.has_home) set_home(T_world_base);
  if (s.stage == State::Stage::start) {
    s.stage = s.config.look_around_first ? State::Stage::looking_around : State::Stage::exploring;
    if (s.config.look_around_first) return look_around_here(T_world_base, kTurnAround_rad, true);
  }
  if (s.stage == State::Stage::looking_around) {
    if (!s.reached && !s.failed) return look_around_here(T_world_base, kTurnAround_rad, false);
    s.stage = State::Stage::exploring;
    s.reached = s.failed = false;
  }
  if (s.stage == State::Stage::going_home || s.stage == State::Stage::at_home) {
    if (s.failed) {
      ++s.home_failures;
      s.homeward_is_new = true;
    }
    s.failed = false;
    if (!s.may_turn_back(now)) return s.home_decision(T_world_base);
    s.stage = State::Stage::exploring;
    s.homeward_is_new = false;
  }
  // A search that was to keep the goal is of no use when the goal is over; another one is.
  if (s.is_searching && (s.reached || s.failed)) {
    s.is_searching = !s.goal.active;
    s.note_goal_is_over(ground, now);
  }
  if (!s.is_searching) {
    if (const auto decision = s.begin_search(ground, T_world_base, now)) return decision;
  }
  WorkBudget budget(s.config.max_units_per_call);
  if (!s.search.go_on(ground, cost, s.aside, budget)) return std::nullopt;
  return s.take_tour(ground, T_world_base, now);
}

void Explorer::work_ahead(const CellGrid<CellState>& ground, const CellGrid<std::uint8_t>& cost,
                          std::span<const std::uint32_t> changed_cells) {
  State& s = *state_;
  if (!s.has_geometry_of(ground)) return s.reset(ground, cost);
  s.search.take_changes(ground, cost, changed_cells);
  s.changes += changed_cells.size();
  if (s.stage != State::Stage::exploring || s.is_searching) return;
  WorkBudget budget(s.config.max_units_ahead_per_call);
  s.search.work_ahead(ground, cost, budget);
}

void Explorer::goal_reached() { state_->reached = true; }

void Explorer::goal_failed(GoalFailure) { state_->failed = true; }

void Explorer::start_again() {
  State& s = *state_;
  s.aside.forgive_blocked();
  s.stage = State::Stage::exploring;
  s.goal.active = s.is_searching = s.reached = s.failed = false;
  s.home_failures = 0;
  s.homeward_is_new = false;
  s.planned_at = 0;
}

void Explorer::map_moved() {
  State& s = *state_;
  s.aside.forgive_blocked();  // it may have been a wall that was drawn twice
  s.goal.active = s.is_searching = s.reached = s.failed = false;
  s.homeward_is_new = s.stage == State::Stage::going_home;
  s.planned_at = 0;
}

void Explorer::set_home(const PlanarPose& T_world_home) {
  state_->home = T_world_home;
  state_->has_home = true;
}

void Explorer::set_energy_left(double seconds) { state_->energy_left_s = seconds; }

void Explorer::set_team(const TeamSight& sight, TimeNs now) { state_->claims.take(sight, now); }

std::size_t Explorer::offers(std::span<Offer, kMostOffers> out) const {
  std::copy_n(state_->offers.offers.begin(), state_->offers.count, out.begin());
  return state_->offers.count;
}

void Explorer::return_home(bool for_energy) {
  state_->is_called_home = true;
  if (for_energy) state_->left[LeftReason::energy] += std::exchange(state_->left.open, 0);
  if (state_->stage != State::Stage::going_home && state_->stage != State::Stage::at_home) state_->turn_home();
}

std::span<const std::uint32_t> Explorer::frontier_cells() const { return state_->search.frontiers().cells(); }

}  // namespace g3d::nav
