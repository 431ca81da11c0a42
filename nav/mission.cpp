// SPDX-License-Identifier: Apache-2.0
#include "nav/mission.hpp"

#include <array>

namespace g3d::nav {
namespace {

using S = MissionState;
using Event = MissionEvent;

struct Row {
  S from;
  Event event;
  S to;
};

// The course of an exploration. Holding and resuming are below, the same for all.
constexpr std::array kCourse{
    Row{S::starting, Event::looked_around, S::exploring}, Row{S::starting, Event::explored, S::returning},
    Row{S::starting, Event::battery_low, S::returning},   Row{S::starting, Event::come_home, S::returning},
    Row{S::exploring, Event::explored, S::returning},     Row{S::exploring, Event::battery_low, S::returning},
    Row{S::exploring, Event::come_home, S::returning},    Row{S::returning, Event::at_home, S::home},
    Row{S::returning, Event::no_way_home, S::needs_help}, Row{S::returning, Event::more_to_see, S::exploring},
};

bool is_course(S state) { return state == S::starting || state == S::exploring || state == S::returning; }

S follow_course(S from, Event event) {
  for (const Row& row : kCourse) {
    if (row.from == from && row.event == event) return row.to;
  }
  return from;
}

}  // namespace

std::string_view name_of(MissionState state) {
  switch (state) {
    case S::starting:
      return "starting";
    case S::exploring:
      return "exploring";
    case S::returning:
      return "returning";
    case S::home:
      return "home";
    case S::paused:
      return "paused";
    case S::stopped:
      return "stopped";
    case S::needs_help:
      return "needs_help";
  }
  return "unknown";
}

bool Mission::is_driving() const { return is_course(state_); }

bool Mission::apply(MissionEvent event) {
  const S before = state_;
  if (is_course(state_)) {
    const S purpose = state_;
    if (event == Event::pause) state_ = S::paused;
    if (event == Event::stop) state_ = S::stopped;
    if (event == Event::lost) state_ = S::needs_help;
    if (state_ == before) state_ = follow_course(state_, event);
    if (!is_course(state_)) held_ = purpose;
    return state_ != before;
  }
  if (state_ == S::home) return false;
  // Held. A stop outranks a pause; "come home" while held changes only what is resumed.
  if (event == Event::resume) state_ = held_;
  if (event == Event::stop) state_ = S::stopped;
  if (event == Event::come_home || event == Event::battery_low) held_ = S::returning;
  return state_ != before;
}

}  // namespace g3d::nav
