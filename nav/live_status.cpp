// SPDX-License-Identifier: Apache-2.0
#include "nav/live_status.hpp"

#include <cmath>

#include "mapper/json_writer.hpp"

namespace g3d::nav {
namespace {

double to_digits(double value, double step) { return std::round(value / step) * step; }
double to_mm(double metres) { return std::round(metres * 1000.0) / 1000.0; }

}  // namespace

LiveStatus status_of(const Navigator& navigator, const hal::kobuki::BaseState& base,
                     const hal::PlanarPose& T_world_base, hal::TimeNs now) {
  LiveStatus status;
  status.stamp_ns = now;
  status.time_s = navigator.report().time_s(now);
  status.path_m = navigator.report().path_m;
  status.turned_rad = navigator.report().rotation_rad;
  status.state = navigator.mission().state();
  status.purpose = navigator.mission().purpose();
  status.T_world_base = T_world_base;
  status.battery_v = base.battery_v;
  status.battery_charge = base.battery_charge;
  status.energy_left_s = base.energy_left_s;
  status.battery_level = base.battery_level;
  status.safety = base.verdict.state;
  status.allowance = base.verdict.allowance;
  status.limited_by = base.verdict.reason;
  status.last_reason = base.last_reason;
  status.last_reason_s = static_cast<double>(now - base.last_reason_ns) * 1e-9;
  return status;
}

std::string to_json(const LiveStatus& status) {
  mapper::JsonWriter json;
  json.begin_object();
  json.member("state", name_of(status.state)).member("purpose", name_of(status.purpose));
  json.member("time_s", to_digits(status.time_s, 0.1)).member("path_m", to_mm(status.path_m));
  json.member("turned_rad", to_mm(status.turned_rad));
  json.key("coverage");
  if (status.coverage < 0.0) {
    json.value(std::nan(""));  // null: nobody knows
  } else {
    json.value(to_digits(status.coverage, 1e-4));
  }
  json.key("pose").begin_object().member("x_m", to_mm(status.T_world_base.x_m));
  json.member("y_m", to_mm(status.T_world_base.y_m)).member("heading_rad", to_mm(status.T_world_base.heading_rad));
  json.end_object();
  json.key("battery").begin_object().member("level", hal::kobuki::to_string(status.battery_level));
  json.member("volts", to_digits(status.battery_v, 0.01)).member("charge", to_digits(status.battery_charge, 0.01));
  json.member("left_s", std::round(status.energy_left_s)).end_object();
  json.key("safety").begin_object().member("state", hal::to_string(status.safety));
  json.member("limited_by", hal::to_string(status.limited_by));
  json.member("forward_mps", status.allowance.forward_mps).member("backward_mps", status.allowance.backward_mps);
  json.member("turn_radps", status.allowance.turn_radps);
  json.member("last_reason", hal::to_string(status.last_reason));
  json.key("last_reason_s");
  json.value(status.last_reason == hal::Condition::count_ ? std::nan("") : to_digits(status.last_reason_s, 0.01));
  json.end_object();
  json.end_object();
  return json.take();
}

}  // namespace g3d::nav
