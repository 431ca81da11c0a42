// SPDX-License-Identifier: Apache-2.0
#include "main_building.hpp"

#include <cmath>
#include <numbers>

#include "hal/sim/base_cable.hpp"
#include "hal/sim/sim_building.hpp"
#include "nav/exploration_report.hpp"

namespace g3d {
namespace {

double milli(double x) { return std::round(1e3 * x) / 1e3; }

void write_pose(mapper::JsonWriter& json, const char* key, const hal::PlanarPose& pose) {
  json.key(key).begin_object().member("x_m", milli(pose.x_m)).member("y_m", milli(pose.y_m));
  json.member("heading_deg", milli(pose.heading_rad * 180.0 / std::numbers::pi)).end_object();
}

}  // namespace

void write_served(mapper::JsonWriter& json, const hal::ServedCounts& counts) {
  json.key("camera").begin_object().member("connected", counts.is_connected);
  json.member("connections", counts.connections).member("frames", counts.frames).member("sent", counts.sent);
  json.key("lost").begin_object().member("slow_reader", counts.slow_reader).member("cut_off", counts.cut_off);
  json.end_object().member("sent_bytes", counts.sent_bytes).member("signs_of_life", counts.signs_of_life);
  json.end_object();
}

void write_stream(mapper::JsonWriter& json, const hal::StreamCounts& counts) {
  json.key("camera").begin_object().member("connections", counts.connections).member("images", counts.images);
  json.member("wrong_camera", counts.wrong_camera).member("settling", counts.settling);
  json.member("missing", counts.missing).member("stalls", counts.stalls);
  json.member("signs_of_life", counts.signs_of_life).member("skipped_bytes", counts.skipped_bytes);
  json.member("longest_wait_ms", milli(static_cast<double>(counts.longest_wait_ns) * 1e-6));
  json.key("rejected").begin_object();
  for (std::size_t i = 0; i < hal::kStreamRejects; ++i) {
    json.member(to_string(static_cast<hal::StreamReject>(i)), counts.rejects[i]);
  }
  json.end_object().end_object();
}

void write_truth_of(mapper::JsonWriter& json, hal::SimBuilding& building, const hal::BaseCable& cable,
                    std::size_t robot, const hal::PlanarPose& start) {
  const hal::RobotRecord& record = building.record(robot);
  const nav::OutsideView outside = nav::outside_view(record);
  write_pose(json, "start", start);
  write_pose(json, "at", building.T_world_base(robot));
  json.member("speed_mps", milli(building.body(robot).velocity().forward_mps));
  json.member("turn_radps", milli(building.body(robot).velocity().turn_radps));
  json.member("driven_m", milli(record.driven_m)).member("turned_rad", milli(record.turned_rad));
  json.member("collisions", record.contacts).member("collisions_measurable", record.contacts_measurable);
  json.member("collisions_moving", record.contacts_moving).member("collisions_robots", record.contacts_robots);
  json.member("collisions_ran_into", record.contacts_ran_into);
  json.member("fastest_collision_mps", milli(record.fastest_contact_mps));
  json.member("closest_clearance_m", milli(record.closest_clearance_m));
  json.member("cliffs", record.cliffs).member("wheel_drops", record.wheel_drops);
  json.key("contacts").begin_array();
  for (std::size_t i = 0; i < std::min(outside.contact_list.size(), kMostContactsTold); ++i) {
    const nav::ContactSeen& contact = outside.contact_list[i];
    json.begin_object().member("at_s", milli(contact.time_s)).member("x_m", milli(contact.x_m));
    json.member("y_m", milli(contact.y_m)).member("speed_mps", milli(contact.speed_mps));
    json.member("moving", contact.is_moving).member("measurable", contact.is_measurable).end_object();
  }
  json.end_array();
  hal::SimKobuki& kobuki = building.kobuki(robot);
  json.key("base").begin_object().member("line", cable.path()).member("connected", cable.is_connected());
  json.member("connections", cable.connections()).member("lost_bytes", cable.lost_bytes());
  json.member("packets_sent", kobuki.packets_sent()).member("drive_commands", kobuki.drive_commands());
  json.member("told_mmps", kobuki.drive().speed_mmps).member("told_radius_mm", kobuki.drive().radius_mm);
  json.member("rejected_commands", kobuki.rejects().total()).end_object();
}

}  // namespace g3d
