// SPDX-License-Identifier: Apache-2.0
#include "nav/surroundings.hpp"

#include <array>
#include <cmath>

namespace g3d::nav {
namespace {

constexpr double kTouchRadius_m = 0.05;
constexpr double kSameThing_m = 1.0;     // touches this near to each other are of one thing
constexpr double kCarefulAbout_m = 0.7;  // a touch: panes are wide
constexpr double kNearTouch_m = 1.8;
constexpr double kSuspect_m = 0.65;  // where what is too near to be measured is taken to stand
constexpr TimeNs kStandPeriod_ns = 250'000'000;
constexpr double kTeammate_m = 0.2;  // so near to a teammate's body it is he who is touched
constexpr std::size_t kMostTouches = 256;
constexpr std::uint8_t kOwnWayCost = 250;
constexpr double kTightSpare_m = 0.01;  // in a tight place; MotionLimits::touch_margin_m

double distance_m(const Waypoint& a, double x_m, double y_m) { return std::hypot(a.x_m - x_m, a.y_m - y_m); }

}  // namespace

double planning_radius_m(double body_radius_m, double cell_m) { return body_radius_m + 0.7 * cell_m; }

Surroundings::Surroundings(const mapper::Grid& grid, const SurroundingsConfig& config)
    : body_radius_m_(config.body_radius_m),
      ground_(grid, config.ground),
      inflation_(ground_.states(), {planning_radius_m(config.body_radius_m, ground_.resolution_m()),
                                    config.inflation_radius_m, config.inflation_decay_perm}),
      tight_(ground_.states(), inflation_, config.body_radius_m, kTightSpare_m),
      trace_(ground_.states(), config.body_radius_m),
      field_(ground_.states()),
      low_view_(ground_.states(), config.low_view),
      near_watch_(ground_.states(), config.near_watch),
      moved_(ground_.states()),
      scan_(config.frame_view.depth_scan),
      passers_(ground_.states(), config.frame_view.passers),
      steps_(ground_.states(), config.frame_view.floor_steps),
      team_cost_(tight_.cost()),
      scratch_(ground_.states().cells.size()),
      is_noted_(ground_.states().cells.size()),
      own_way_(tight_.cost()) {
  changed_.reserve(is_noted_.size());
  touches_.reserve(kMostTouches);
  near_touches_.reserve(kMostTouches);
}

void Surroundings::note_changed(std::span<const std::uint32_t> cells) {
  team_cost_.note_changed(tight_.cost(), cells);
  for (const std::uint32_t cell : cells) {
    if (is_noted_[cell] != 0) continue;
    is_noted_[cell] = 1;
    changed_.push_back(cell);
  }
}

void Surroundings::forget_changes() {
  for (const std::uint32_t cell : changed_) is_noted_[cell] = 0;
  changed_.clear();
}

void Surroundings::take_over_changes() {
  const std::span<const std::uint32_t> fresh = ground_.changed_cells().subspan(taken_over_);
  taken_over_ = ground_.changed_cells().size();
  if (fresh.empty()) return;
  if (!is_moving_) moved_.note(ground_, fresh, now_ns_);
  inflation_.update(ground_.states(), fresh);
  tight_.update(ground_.states(), inflation_, fresh);
  note_changed(fresh);
  note_changed(tight_.changed_cells());
}

void Surroundings::on_map(const mapper::VoxelMap& map, std::span<const std::uint32_t> changed_slots,
                          const hal::PlanarPose& T_world_base, const mapper::ChangedColumns& columns) {
  take_over_changes();  // marks since the last frame
  if (columns.cells_per_block != 0) {
    ground_.update(columns);
    ground_.note_slots(map, changed_slots);
  } else {
    ground_.update(map, changed_slots);
  }
  taken_over_ = 0;
  take_over_changes();
  if (!has_frames_) low_view_.look(ground_.states(), T_world_base);
}

void Surroundings::on_frame(const hal::Frame& frame, const hal::CameraModel& camera,
                            const hal::PlanarPose& T_world_base, TimeNs now) {
  const TeamBodies* const teammates = bodies_.empty() ? nullptr : &bodies_;
  near_watch_.look(frame, camera, ground_.states(), moved_, T_world_base, now, teammates);
  has_frames_ = true;
  scan_.look(frame, camera);
  low_view_.look(ground_.states(), T_world_base, &scan_);
  passers_.look(scan_, ground_.states(), moved_, T_world_base, now, teammates);
  steps_.look(frame, camera, ground_.states(), T_world_base);
  for (const std::uint32_t cell : steps_.changed_cells()) {
    const Cell c = ground_.states().cell(cell);
    ground_.mark_step(c, steps_.is_step(c));
  }
  take_over_changes();
}

void Surroundings::on_team(const TeamSight& sight, TimeNs now) {
  bodies_.take(sight);
  bodies_.look_around(here_, now);
  let_bodies_stand(now);
}

void Surroundings::let_bodies_stand(TimeNs now) {
  next_stand_ns_ = now + kStandPeriod_ns;
  bodies_.forget_gone(now, [this](double x_m, double y_m) { return passers_.looked_ns(x_m, y_m); });
  std::array<TeamCost::Body, kMostTeammates> standing;
  std::size_t count = 0;
  const double own_m = planning_radius_m(body_radius_m_, ground_.resolution_m());
  bodies_.for_standing(now, [&](double x_m, double y_m, double radius_m) {
    standing[count++] = {x_m, y_m, own_m + radius_m};
  });
  team_cost_.stand(tight_.cost(), std::span(standing).first(count));
}

void Surroundings::on_pose(const hal::PlanarPose& pose, TimeNs now) {
  now_ns_ = now;
  if (!bodies_.empty()) {
    bodies_.look_around(pose, now);
    if (now >= next_stand_ns_) let_bodies_stand(now);  // who falls silent stands
  }
  if (!trace_.tread(pose)) return;
  here_ = pose;
  way_.tread({now, pose.x_m, pose.y_m});
  ground_.mark_free_disc(pose.x_m, pose.y_m, body_radius_m_);
  take_over_changes();
  tight_.tread(ground_.states(), inflation_, pose.x_m, pose.y_m);
  note_changed(tight_.changed_cells());
  find_near_touches();
}

void Surroundings::find_near_touches() {
  near_touches_.clear();
  for (const Waypoint& touch : touches_) {
    if (distance_m(touch, here_.x_m, here_.y_m) < kNearTouch_m) near_touches_.push_back(touch);
  }
}

void Surroundings::mark_all_touches() {
  for (std::size_t i = 0; i < touches_.size(); ++i) mark_touches_with(touches_[i], i);
}

// Touches near one another are of one thing: what lies between them is closed as well.
void Surroundings::mark_touches_with(const Waypoint& touch, std::size_t others) {
  ground_.mark_contact(touch.x_m, touch.y_m, kTouchRadius_m);
  for (std::size_t i = 0; i < others; ++i) {
    const Waypoint& other = touches_[i];
    const double length_m = distance_m(other, touch.x_m, touch.y_m);
    if (length_m > kSameThing_m) continue;
    for (double s = kTouchRadius_m; s < length_m; s += kTouchRadius_m) {
      const double x_m = other.x_m + s / length_m * (touch.x_m - other.x_m);
      const double y_m = other.y_m + s / length_m * (touch.y_m - other.y_m);
      if (!trace_.is_trodden(ground_.states().cell_of(x_m, y_m))) ground_.mark_contact(x_m, y_m, kTouchRadius_m);
    }
  }
}

void Surroundings::on_touch(const hal::PlanarPose& T_world_base, double side_rad) {
  const Waypoint touch = where_touched(ground_.states(), T_world_base, side_rad, body_radius_m_);
  if (bodies_.is_near(touch.x_m, touch.y_m, kTeammate_m, now_ns_)) return;  // no part of the building
  mark_touches_with(touch, touches_.size());
  if (touches_.size() < kMostTouches) {
    touches_.push_back(touch);
    near_touches_.push_back(touch);
  }
  take_over_changes();
}

void Surroundings::close_suspects() {
  near_watch_.for_suspicious(kSuspect_m, [this](double x_m, double y_m) {
    if (bodies_.is_near(x_m, y_m, kTeammate_m, now_ns_)) return;
    ground_.mark_contact(x_m, y_m, kTouchRadius_m);
    has_closed_ = true;
  });
  take_over_changes();
}

bool Surroundings::reopen() {
  if (!has_closed_) return false;
  has_closed_ = false;
  ground_.forget_contacts();
  mark_all_touches();
  take_over_changes();
  return true;
}

bool Surroundings::trust_own_way() {
  trusts_own_way_ = true;
  const bool opens = tight_.trust_own_way(ground_.states(), inflation_);
  note_changed(tight_.changed_cells());
  return opens;
}

void Surroundings::forget_touches() {
  has_closed_ = false;
  ground_.forget_contacts();
  touches_.clear();
  near_touches_.clear();
  take_over_changes();
}

void Surroundings::move(const mapper::submaps::ChainMove& move) {
  field_.compute(way_.places(), move);
  for (Waypoint& touch : touches_) {
    const Trodden there = field_.moved({0, touch.x_m, touch.y_m});
    touch = {there.x_m, there.y_m};
  }
  way_.move(move);
  low_view_.move(field_, scratch_);
  steps_.move(field_, scratch_);

  ground_.forget_marks();
  has_closed_ = false;
  trace_.clear();
  for (const Trodden& place : way_.places()) {
    (void)trace_.tread({place.x_m, place.y_m, 0.0});
    ground_.mark_free_disc(place.x_m, place.y_m, body_radius_m_);
    here_ = {place.x_m, place.y_m, 0.0};
  }
  steps_.for_steps([this](Cell c) { ground_.mark_step(c, true); });
  mark_all_touches();
  take_over_changes();
  tight_.forget_way(ground_.states(), inflation_);
  note_changed(tight_.changed_cells());
  for (const Trodden& place : way_.places()) {
    tight_.tread(ground_.states(), inflation_, place.x_m, place.y_m);
    note_changed(tight_.changed_cells());
  }
  find_near_touches();
  is_moving_ = false;
}

const CellGrid<std::uint8_t>& Surroundings::cost_of_own_way() {
  own_way_.cells = tight_.cost().cells;
  for (std::size_t i = 0; i < own_way_.cells.size(); ++i) {
    if (own_way_.cells[i] >= kInscribedCost && trace_.is_trodden(own_way_.cell(i))) own_way_.cells[i] = kOwnWayCost;
  }
  return own_way_;
}

Extent Surroundings::extent(Cell c) const {
  if (!trusts_own_way_) return Extent::square;
  int trodden = 0;
  for (int y = c.y - 1; y <= c.y + 1; ++y) {
    for (int x = c.x - 1; x <= c.x + 1; ++x) trodden += trace_.is_trodden({x, y}) ? 1 : 0;
  }
  if (trodden == 0 || trodden == 9) return Extent::square;  // beyond, or right where the body was: something has come
  for (const Waypoint& touch : near_touches_) {
    if (distance_m(touch, states().centre_x_m(c), states().centre_y_m(c)) < kCarefulAbout_m) return Extent::square;
  }
  return trace_.is_trodden(c) ? Extent::nothing : Extent::middle;
}

bool Surroundings::is_seen(Cell c) const {
  if (trace_.is_trodden(c)) return true;
  for (const Waypoint& touch : near_touches_) {
    if (distance_m(touch, states().centre_x_m(c), states().centre_y_m(c)) < kCarefulAbout_m) return false;
  }
  return ground_.is_floor_seen(c) || low_view_.is_seen(c);
}

}  // namespace g3d::nav
