// SPDX-License-Identifier: Apache-2.0
#include "nav/exploration_report.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

#include "hal/sim/sim_building.hpp"

namespace g3d::nav {
namespace {

double rounded(double x, double parts) { return std::round(x * parts) / parts; }
double milli(double x) { return rounded(x, 1e3); }

void write_time(mapper::JsonWriter& json, const char* key, const std::optional<double>& time_s) {
  if (time_s) {
    json.member(key, milli(*time_s));
  } else {
    json.key(key).value(std::nan(""));  // null: never reached
  }
}

void write_contacts(mapper::JsonWriter& json, const std::vector<ContactSeen>& contacts) {
  json.key("contacts").begin_array();
  for (const ContactSeen& contact : contacts) {
    json.begin_object().member("at_s", milli(contact.time_s));
    json.member("x_m", milli(contact.x_m)).member("y_m", milli(contact.y_m));
    json.member("speed_mps", milli(contact.speed_mps)).member("bumper_flags", contact.bumper_flags);
    json.member("solid", contact.solid).member("moving", contact.is_moving);
    json.member("measurable", contact.is_measurable).member("ran_into", contact.is_run_into).end_object();
  }
  json.end_array();
}

std::string spoken_time(const std::optional<double>& time_s) {
  return time_s ? fmt::format("{:.0f} s", *time_s) : std::string("never");
}

}  // namespace

OutsideView outside_view(const hal::RobotRecord& record) {
  OutsideView view;
  view.contacts = record.contacts;
  view.contacts_measurable = record.contacts_measurable;
  view.contacts_moving = record.contacts_moving;
  view.contacts_ran_into = record.contacts_ran_into;
  view.fastest_contact_mps = record.fastest_contact_mps;
  view.closest_clearance_m = record.closest_clearance_m;
  for (const hal::ContactEvent& event : record.events) {
    view.contact_list.push_back({static_cast<double>(event.time_ns) / 1e9, event.at.x_m, event.at.y_m, event.speed_mps,
                                 event.bumper, event.solid, event.moving, event.measurable, event.ran_into});
  }
  return view;
}

void write_exploration(mapper::JsonWriter& json, const ExplorationReport& report) {
  const MissionReport& mission = *report.mission;
  json.key("exploration").begin_object();
  json.key("coverage").begin_array();
  for (const CoverageSample& sample : mission.coverage()) {
    json.begin_array().value(milli(sample.time_s)).value(rounded(sample.fraction, 1e5)).end_array();
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
    json.member("collisions_ran_into", outside.contacts_ran_into);
    json.member("fastest_collision_mps", milli(outside.fastest_contact_mps));
    json.member("closest_clearance_m", milli(outside.closest_clearance_m));
    write_contacts(json, outside.contact_list);
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
  text +=
      fmt::format("  explored    {:.0f} s, {:.1f} m driven, {:.0f} degrees turned, {}\n", report.time_s, mission.path_m,
                  mission.rotation_rad * 57.29578, report.home ? "home again" : "not home: " + report.state);
  if (!mission.coverage().empty()) {
    text += fmt::format("  coverage    {:.2f} % of what can be seen; 90 % after {}, 95 % {}, 99 % {}\n",
                        100.0 * mission.coverage().back().fraction, spoken_time(mission.time_to_s(0.90)),
                        spoken_time(mission.time_to_s(0.95)), spoken_time(mission.time_to_s(0.99)));
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

std::string exploration_title(std::string_view world, const ExplorationReport& report) {
  const MissionReport& mission = *report.mission;
  std::string title = fmt::format("{}:", world);
  if (!mission.coverage().empty()) {
    title += fmt::format(" {:.1f} % seen, 95 %: {}, 99 %: {},", 100.0 * mission.coverage().back().fraction,
                         spoken_time(mission.time_to_s(0.95)), spoken_time(mission.time_to_s(0.99)));
  }
  title += fmt::format(" {} {:.0f} s, {:.0f} m", report.home ? "home after" : "not home after", report.time_s,
                       mission.path_m);
  for (char& letter : title)
    letter = letter == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  return title;
}

}  // namespace g3d::nav
