// SPDX-License-Identifier: Apache-2.0
#include "main_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "hal/linux/cpu_time.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_setup.hpp"
#include "nav/exploration_picture.hpp"

namespace g3d {

hal::Result<CameraChoice> choose_camera(const board::Board& board, const std::string& wanted) {
  CameraChoice choice{camera_model(board), board.camera_rate_hz};
  if (wanted.empty()) return choice;
  const std::string_view text = wanted;
  const std::size_t by = text.find('x');
  const std::size_t at = text.find('@');
  const auto number = [&](std::size_t from, std::size_t to) {
    return from <= to && to <= text.size() ? hal::parse_double(text.substr(from, to - from)).value_or(0.0) : 0.0;
  };
  const bool has_form = by != std::string_view::npos && at != std::string_view::npos && by < at;
  const double width = has_form ? number(0, by) : 0.0;
  const double height = has_form ? number(by + 1, at) : 0.0;
  const double rate_hz = has_form ? number(at + 1, text.size()) : 0.0;
  const auto is_size = [](double px) { return px >= 16 && px <= hal::kMaxImageSide_px && px == std::floor(px); };
  if (!is_size(width) || !is_size(height) || !(rate_hz >= 0.5 && rate_hz <= 240.0)) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("--camera '{}': not WIDTHxHEIGHT@HZ with 16 to {} pixels and 0.5 to 240 Hz, such as "
                                  "160x120@10",
                                  wanted, hal::kMaxImageSide_px)};
  }
  choice.model = hal::scaled_kinect(static_cast<int>(width), static_cast<int>(height));
  choice.rate_hz = rate_hz;
  return choice;
}

hal::Result<void> set_area(const std::string& text, nav::ExplorerConfig& explorer) {
  const auto area = choose_rectangle("--area", text);
  if (!area) return area.error();
  if (!area.value()) return {};
  explorer.area_min_x_m = area.value()->min_x_m;
  explorer.area_min_y_m = area.value()->min_y_m;
  explorer.area_max_x_m = area.value()->max_x_m;
  explorer.area_max_y_m = area.value()->max_y_m;
  return {};
}

nav::RobotConfig robot_config(const board::Board& board, const MappingOptions& options, const hal::CameraModel& camera,
                              const hal::PlanarPose& T_world_start) {
  nav::RobotConfig config;
  config.mapper = mapper_config(board, options);
  config.camera = camera;
  config.T_base_camera = mount_pose(board);
  config.T_world_start = T_world_start;
  config.robot_height_m = board.robot_height_m;
  config.align = align_options(options);
  if (config.align) {
    config.align->surface.slots *= 2;  // an hour's drive, not a recording
    config.mapper.surface_slots = static_cast<std::uint32_t>(config.align->surface.slots);
  }
  if (options.loops) {
    config.loops.emplace();
    config.mapper.backend = mapper::Backend::cpu;
  }
  nav::NavigatorConfig& navigator = config.navigator;
  navigator.ground.centre_x_m = T_world_start.x_m;
  navigator.ground.centre_y_m = T_world_start.y_m;
  navigator.ground.heights.body_height_m = board.robot_height_m;
  navigator.ground.speckle_level = static_cast<std::uint8_t>(mapper::kUnknownLevel + board.map_hit);
  navigator.ground.max_slots = config.mapper.capacity.blocks;
  navigator.explorer.body_radius_m = board.robot_radius_m;
  navigator.explorer.camera_forward_m = board.mount_x_m;
  navigator.explorer.near_m = board.map_near_m;
  navigator.explorer.far_m = board.map_far_m;
  navigator.explorer.view_rad = 2.0 * std::atan(0.5 * camera.width_px / static_cast<double>(camera.fx_px));
  navigator.follower.limits.body_radius_m = board.robot_radius_m;
  navigator.near_watch.body_radius_m = board.robot_radius_m;
  navigator.near_watch.forward_m = board.mount_x_m;
  navigator.near_watch.near_m = board.map_near_m;
  navigator.frame_view.depth_scan.T_base_camera = mount_pose(board);
  navigator.frame_view.floor_steps.T_base_camera = mount_pose(board);
  navigator.frame_view.depth_scan.body_height_m = board.robot_height_m;
  navigator.frame_view.passers.body_radius_m = board.robot_radius_m;
  return config;
}

hal::Result<Staging> read_staging(const StagingOptions& options) {
  Staging staging;
  for (const std::string& text : options.fail) {
    const auto fault = hal::parse_fault(text);
    if (!fault) return hal::Error{fault.error().reason, "--fail " + fault.error().text};
    staging.faults.push_back(fault.value());
  }
  for (const std::string& text : options.at) {
    const auto word = nav::parse_timed_word(text);
    if (!word) return hal::Error{word.error().reason, "--at " + word.error().text};
    staging.words.push_back(word.value());
  }
  std::stable_sort(staging.words.begin(), staging.words.end(),
                   [](const nav::TimedWord& a, const nav::TimedWord& b) { return a.at_ns < b.at_ns; });
  return staging;
}

hal::BaseDrift drift_like(const std::string& name) {
  return name == "rough" ? hal::BaseDrift::rough : hal::BaseDrift::kobuki;
}

void set_battery(hal::SimKobukiOptions& base, const StagingOptions& options) {
  if (options.battery_min > 0.0) base.battery_life_s = 60.0 * options.battery_min;
}

hal::Result<std::unique_ptr<hal::ControlSocket>> open_control(const StagingOptions& options, const std::string& out_dir,
                                                              nav::Hotline& hotline, const AskedFirst& first) {
  if (options.control.empty() && out_dir.empty()) return std::unique_ptr<hal::ControlSocket>{};
  const std::string path = options.control.empty() ? out_dir + "/control" : options.control;
  return hal::ControlSocket::open(path, [&hotline, first](std::string_view request) {
    if (first) {
      if (auto answer = first(request)) return std::move(*answer);
    }
    return hotline.answer(request);
  });
}

void write_control(mapper::JsonWriter& json, const nav::Hotline& hotline, const hal::ControlCounts& counts) {
  json.key("control").begin_object();
  for (std::size_t i = 0; i < static_cast<std::size_t>(nav::PersonWord::count_); ++i) {
    const auto word = static_cast<nav::PersonWord>(i);
    json.member(nav::to_string(word), hotline.said(word));
  }
  json.key("rejected").begin_object().member("unknown_word", hotline.unknown_words());
  json.member("too_many_words", hotline.refused_words()).member("too_long", counts.too_long);
  json.member("too_slow", counts.too_slow).member("too_many_clients", counts.too_many).end_object();
  json.end_object();
}

void write_cpu(mapper::JsonWriter& json, std::span<const nav::ThreadTime> times, double run_s) {
  const auto to_ms = [](double seconds) { return std::round(seconds * 1000.0) / 1000.0; };
  double robot_s = 0.0;
  json.key("cpu_s").begin_object();
  for (const nav::ThreadTime& time : times) {
    json.member(time.name, to_ms(time.cpu_s));
    if (std::string_view(time.name) != "camera_read") robot_s += time.cpu_s;
  }
  json.member("robot", to_ms(robot_s)).member("process", to_ms(static_cast<double>(hal::process_cpu_ns()) * 1e-9));
  json.member("robot_cores", run_s > 0.0 ? to_ms(robot_s / run_s) : 0.0).end_object();
}

std::vector<std::pair<std::string, std::uint64_t>> safety_stops(const hal::kobuki::BaseState& base) {
  std::vector<std::pair<std::string, std::uint64_t>> stops;
  for (std::size_t i = 0; i < hal::kConditionCount; ++i) {
    stops.emplace_back(hal::to_string(static_cast<hal::Condition>(i)), base.began[i]);
  }
  return stops;
}

hal::Result<mapper::WrittenFile> write_picture(const nav::ExplorationReport& explored, const nav::Navigator& navigator,
                                               std::span<const hal::Pose> poses, const std::string& place,
                                               const std::string& path) {
  const auto bytes = nav::write_exploration_picture(
      {&navigator.ground().states(), navigator.frontier_cells(), poses, navigator.home(), explored.mission->coverage(),
       explored.time_s, nav::exploration_title(place, explored)},
      path);
  if (!bytes) return bytes.error();
  return mapper::WrittenFile{path, "way, frontiers and coverage", bytes.value()};
}

void write_base(mapper::JsonWriter& json, const BaseReport& report) {
  const hal::kobuki::BaseState& state = report.state;
  json.key("base").begin_object().member("line", report.line).member("low_latency", report.low_latency);
  json.member("packets", state.packets).member("received_bytes", state.received_bytes);
  json.member("rejected_packets", state.rejects.total()).member("skipped_bytes", state.rejects.skipped_bytes);
  json.member("line_losses", report.health.line_losses).member("ticks", state.ticks);
  json.member("urgent_stops", state.urgent_stops).member("refused_writes", report.refused_writes);
  json.member("realtime", report.health.is_realtime).member("guard_alive", report.guard_was_alive);
  json.member("battery_v", std::round(state.battery_v * 100.0) / 100.0).member("stands", report.stands);
  json.end_object();
}

}  // namespace g3d
