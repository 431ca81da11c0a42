// SPDX-License-Identifier: Apache-2.0
#include "nav/exploration_report.hpp"

#include <fmt/format.h>

#include <cmath>

namespace g3d::nav {
namespace {

double rounded(double x, double step) { return std::round(x / step) * step; }
double milli(double x) { return std::round(x * 1e3) / 1e3; }

void write_time(mapper::JsonWriter& json, const char* key, const std::optional<double>& time_s) {
  if (time_s) {
    json.member(key, milli(*time_s));
  } else {
    json.key(key).value(std::nan(""));  // null: never reached
  }
}

}  // namespace

void write_exploration(mapper::JsonWriter& json, const ExplorationReport& report) {
  const MissionReport& mission = *report.mission;
  json.key("exploration").begin_object();
  json.key("coverage").begin_array();
  for (const CoverageSample& sample : mission.coverage()) {
    json.begin_array().value(milli(sample.time_s)).value(rounded(sample.fraction, 1e-5)).end_array();
  }
  json.end_array();
  write_time(json, "t90_s", mission.time_to_s(0.90));
  write_time(json, "t95_s", mission.time_to_s(0.95));
  write_time(json, "t99_s", mission.time_to_s(0.99));
  json.member("time_s", milli(report.time_s)).member("path_m", milli(mission.path_m));
  json.member("rotation_rad", milli(mission.rotation_rad));
  if (report.outside) {
    const OutsideView& outside = *report.outside;
    json.member("collisions", outside.contacts).member("collisions_measurable", outside.contacts_measurable);
    json.member("collisions_moving", outside.contacts_moving);
    json.member("fastest_collision_mps", milli(outside.fastest_contact_mps));
    json.member("closest_clearance_m", milli(outside.closest_clearance_m));
  }
  json.member("home", report.home).member("state", report.state);
  json.key("stops").begin_object();
  for (std::size_t i = 0; i < kStopReasons; ++i) json.member(name_of(static_cast<StopReason>(i)), mission.stops[i]);
  json.end_object();
  json.key("safety").begin_object();
  for (const auto& [name, count] : report.safety_stops) json.member(name, count);
  json.end_object();
  json.key("frontiers_left").begin_object();
  for (std::size_t i = 0; i < kLeftReasons; ++i) {
    json.member(name_of(static_cast<LeftReason>(i)), mission.frontiers_left.clusters[i]);
  }
  json.member("open", mission.frontiers_left.open).end_object();
  json.member("goals_reached", mission.goals_reached).member("goals_failed", mission.goals_failed);
  json.member("recoveries", mission.recoveries).end_object();
}

std::string exploration_text(const ExplorationReport& report) {
  const MissionReport& mission = *report.mission;
  std::string text;
  const auto time = [](const std::optional<double>& t) {
    return t ? fmt::format("{:.0f} s", *t) : std::string("never");
  };
  text +=
      fmt::format("  explored    {:.0f} s, {:.1f} m driven, {:.0f} degrees turned, {}\n", report.time_s, mission.path_m,
                  mission.rotation_rad * 57.29578, report.home ? "home again" : "not home: " + report.state);
  if (!mission.coverage().empty()) {
    text += fmt::format("  coverage    {:.2f} % of what can be seen; 90 % after {}, 95 % {}, 99 % {}\n",
                        100.0 * mission.coverage().back().fraction, time(mission.time_to_s(0.90)),
                        time(mission.time_to_s(0.95)), time(mission.time_to_s(0.99)));
  }
  if (report.outside) {
    text +=
        fmt::format("  contacts    {}, of which the camera could have foreseen {}; closest clearance {:.2f} m\n",
                    report.outside->contacts, report.outside->contacts_measurable, report.outside->closest_clearance_m);
  }
  std::string left;
  for (std::size_t i = 0; i < kLeftReasons; ++i) {
    if (const auto count = mission.frontiers_left.clusters[i]) {
      left += fmt::format("{}{} {}", left.empty() ? "" : ", ", count, name_of(static_cast<LeftReason>(i)));
    }
  }
  if (mission.frontiers_left.open > 0) {
    left += fmt::format("{}{} still open", left.empty() ? "" : ", ", mission.frontiers_left.open);
  }
  text += fmt::format("  left        {}\n", left.empty() ? "nothing" : left);
  return text;
}

}  // namespace g3d::nav
