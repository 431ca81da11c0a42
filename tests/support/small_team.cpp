// SPDX-License-Identifier: Apache-2.0
#include "tests/support/small_team.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace g3d::tests {
namespace {

constexpr double kTeamStep_s = 0.02;
constexpr hal::TimeNs kSmallTeamStep_ns = 20'000'000;
constexpr double kSurvey_m = 0.7;
constexpr double kSurveyTurn_rad = 0.785398;

bool is_in_box(const std::vector<Box>& boxes, double x_m, double y_m) {
  return std::any_of(boxes.begin(), boxes.end(),
                     [&](const Box& b) { return x_m >= b.x0_m && x_m <= b.x1_m && y_m >= b.y0_m && y_m <= b.y1_m; });
}

}  // namespace

std::vector<Box> walls_around(const Box& inner, double thick_m) {
  return {{inner.x0_m - thick_m, inner.y0_m - thick_m, inner.x1_m + thick_m, inner.y0_m},
          {inner.x0_m - thick_m, inner.y1_m, inner.x1_m + thick_m, inner.y1_m + thick_m},
          {inner.x0_m - thick_m, inner.y0_m, inner.x0_m, inner.y1_m},
          {inner.x1_m, inner.y0_m, inner.x1_m + thick_m, inner.y1_m}};
}

std::optional<nav::Decision> ErrandChooser::decide(const nav::CellGrid<nav::CellState>&,
                                                   const nav::CellGrid<std::uint8_t>&, std::span<const std::uint32_t>,
                                                   const hal::PlanarPose&, hal::TimeNs) {
  nav::Decision decision;
  decision.kind = nav::DecisionKind::goal;
  decision.goal = places_[next_];
  decision.is_new = std::exchange(is_new_, false);
  return decision;
}

SmallTeam::SmallTeam(const std::vector<Box>& walls, const Box& extent, const std::vector<Plan>& plans,
                     const SmallTeamOptions& options)
    : options_(options), floor_(extent), random_(options.seed) {
  for (const Plan& plan : plans) {
    members_.push_back(std::make_unique<Member>(KinematicRobot(walls, plan.start)));
    Member& member = *members_.back();
    nav::NavigatorConfig config;
    config.ground.side_m = 25.6;
    config.make_chooser = [&](const nav::ExplorerConfig&) {
      auto errands = std::make_unique<ErrandChooser>(plan.places);
      member.errands = errands.get();
      return errands;
    };
    member.navigator = std::make_unique<nav::Navigator>(floor_.map().grid(), config);
    member.sight.self = members_.size();
  }
  // Somebody has been everywhere before.
  for (double y_m = extent.y0_m + 0.5 * kSurvey_m; y_m < extent.y1_m; y_m += kSurvey_m) {
    for (double x_m = extent.x0_m + 0.5 * kSurvey_m; x_m < extent.x1_m; x_m += kSurvey_m) {
      if (is_in_box(walls, x_m, y_m)) continue;
      for (double turn_rad = -3.0; turn_rad < 3.0; turn_rad += kSurveyTurn_rad) {
        floor_.look(KinematicRobot(walls, {x_m, y_m, turn_rad}));
        for (const auto& member : members_) member->navigator->on_map(floor_.map(), floor_.changed_slots(), {}, 0);
      }
    }
  }
}

void SmallTeam::speak() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (members_[i]->is_dead) continue;
    const nav::TeamWord word = members_[i]->navigator->team_word(now_);
    nav::Teammate mate;
    mate.robot = i + 1;
    mate.T_world_base = word.T_world_base;
    mate.told_ns = now_;
    mate.is_moving = word.is_moving;
    mate.way = word.way;
    mate.way_count = word.way_count;
    mate.has_goal = word.has_goal;
    mate.goal = word.goal;
    for (std::size_t to = 0; to < members_.size(); ++to) {
      if (to == i || random_.happens(options_.loss)) continue;
      members_[to]->mail.push_back({now_ + static_cast<hal::TimeNs>(options_.word_delay_s * 1e9), i, mate});
    }
  }
}

void SmallTeam::listen(Member& member) {
  while (!member.mail.empty() && member.mail.front().at <= now_) {
    nav::TeamSight& sight = member.sight;
    const nav::Teammate& mate = member.mail.front().mate;
    const auto end = sight.mates.begin() + static_cast<std::ptrdiff_t>(sight.count);
    const auto known =
        std::find_if(sight.mates.begin(), end, [&](const nav::Teammate& other) { return other.robot == mate.robot; });
    if (known == end) ++sight.count;
    *known = mate;
    member.mail.pop_front();
    member.navigator->on_team(sight, now_);
  }
}

void SmallTeam::step() {
  if (now_ >= next_word_) {
    next_word_ += static_cast<hal::TimeNs>(options_.word_period_s * 1e9);
    if (now_ > 0) speak();
  }
  for (const auto& member : members_) {
    hal::Twist wanted;
    if (!member->is_dead) {
      listen(*member);
      nav::BaseView view;
      view.T_world_base = member->robot.pose();
      view.velocity = member->robot.velocity();
      member->navigator->on_base(view, now_);
      wanted = member->navigator->step(now_);
    }
    member->robot.step(wanted, kTeamStep_s);
  }
  for (std::size_t i = 0; i < members_.size(); ++i) {
    for (std::size_t j = i + 1; j < members_.size(); ++j) {
      const double apart_m = std::hypot(pose(i).x_m - pose(j).x_m, pose(i).y_m - pose(j).y_m);
      least_gap_m_ = std::min(least_gap_m_, apart_m - 2.0 * kKinematicBody_m);
    }
  }
  now_ += kSmallTeamStep_ns;
}

bool SmallTeam::run_until_each_reached(int places, double limit_s) {
  const auto have_all = [&] {
    return std::all_of(members_.begin(), members_.end(),
                       [&](const auto& member) { return member->is_dead || member->errands->reached() >= places; });
  };
  const hal::TimeNs until = now_ + static_cast<hal::TimeNs>(limit_s * 1e9);
  while (now_ < until && !have_all()) step();
  return have_all();
}

int SmallTeam::wall_contacts() const {
  int contacts = 0;
  for (const auto& member : members_) contacts += member->robot.contacts();
  return contacts;
}

}  // namespace g3d::tests
