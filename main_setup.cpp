// SPDX-License-Identifier: Apache-2.0
#include "main_setup.hpp"

#include "mapper/map_hash.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "board/board_file.hpp"
#include "hal/replay/decimal.hpp"

namespace g3d {
namespace {

constexpr double kLargestFootprint_m = 10.0;

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace

/// The mount's angles say where the optical axis points; elevation is the opposite of ROS's pitch. Below them stands
/// the turn from the body's axes (x forward) to the optical ones (z forward).
hal::Pose mount_pose(const board::Board& board) {
  constexpr double kQuarter_rad = std::numbers::pi / 2;
  const hal::Pose T_base_body =
      hal::from_xyz_rpy(board.mount_x_m, board.mount_y_m, board.mount_z_m, radians(board.mount_roll_deg),
                        -radians(board.mount_pitch_deg), radians(board.mount_yaw_deg));
  return hal::compose(T_base_body, hal::from_xyz_rpy(0, 0, 0, -kQuarter_rad, 0, -kQuarter_rad));
}

hal::Result<board::Board> effective_board(const MappingOptions& options) {
  hal::Result<board::Board> loaded =
      options.board_path.empty() ? board::Board{} : board::load_board(options.board_path);
  if (!loaded) return loaded;
  board::Board& board = loaded.value();
  board.map_resolution_m = options.resolution_m.value_or(board.map_resolution_m);
  board.map_integrator = options.integrator.value_or(board.map_integrator);
  board.map_mode = options.mode.value_or(board.map_mode);
  board.map_threads = options.threads.value_or(board.map_threads);
  board.map_memory_mb = options.memory_mb.value_or(board.map_memory_mb);
  board.map_window_radius_m = options.window_m.value_or(board.map_window_radius_m);
  return loaded;
}

mapper::MapperConfig mapper_config(const board::Board& board, const MappingOptions& options) {
  mapper::MapperConfig config;
  config.resolution_m = static_cast<float>(board.map_resolution_m);
  config.integrator = *mapper::integrator_from_string(board.map_integrator);
  config.mode = *mapper::mode_from_string(board.map_mode);
  config.steps = {static_cast<std::uint8_t>(board.map_hit), static_cast<std::uint8_t>(board.map_miss)};
  config.near_m = static_cast<float>(board.map_near_m);
  config.far_m = static_cast<float>(board.map_far_m);
  config.with_colour = !options.no_colour;
  config.threads = board.map_threads;
  config.capacity = mapper::capacity_for_bytes(static_cast<std::size_t>(board.map_memory_mb) * 1'000'000);
  config.backend = options.mapper == "cpu"    ? mapper::Backend::cpu
                   : options.mapper == "cuda" ? mapper::Backend::cuda
                                              : mapper::Backend::automatic;
  return config;
}

std::optional<std::string> missing_card(const mapper::Mapper& mapper, const MappingOptions& options) {
  if (options.mapper != "cuda" || std::string_view(mapper.backend_name()) == "cuda") return std::nullopt;
  return fmt::format("--mapper cuda: {}; use --mapper cpu or auto", mapper.card().problem);
}

void report_mapper(const mapper::Mapper& mapper, mapper::RunReport& report) {
  report.mapper = mapper.backend_name();
  const mapper::CardReport card = mapper.card();
  if (card.name.empty()) return;
  std::string note =
      fmt::format("{} frames by {}, {} by the processor", card.frames_on_card, card.name, card.frames_on_cpu);
  if (card.losses > 0) note += fmt::format("; the card was lost {} times, at last: {}", card.losses, card.problem);
  report.notes.push_back(std::move(note));
}

void report_map(const mapper::Mapper& mapper, mapper::RunReport& report) {
  const mapper::MapCounts counts = mapper.map().counts();
  report.occupied = counts.occupied;
  report.free = counts.free;
  report.memory_bytes = mapper.map().memory().used_bytes;
  report.hash = mapper::map_hash(mapper.map());
  report_mapper(mapper, report);
}

std::optional<mapper::align::AlignOptions> align_options(const MappingOptions& options) {
  if (options.odometry == "given") return std::nullopt;
  mapper::align::AlignOptions align;
  align.motion = *mapper::align::motion_from_string(options.motion.value_or("planar"));
  align.source =
      options.odometry == "none" ? mapper::align::OdometrySource::none : mapper::align::OdometrySource::measured;
  return align;
}

std::optional<std::string> loops_problem(const MappingOptions& options) {
  if (!options.loops) return std::nullopt;
  if (options.odometry == "given") return "--loops corrects poses that are aligned; add --odometry aligned";
  const char* other = options.checkpoint_s > 0.0 ? "--checkpoint"
                      : options.mapper == "cuda" ? "--mapper cuda"
                                                 : nullptr;
  if (other == nullptr) return std::nullopt;
  return fmt::format("--loops moves the whole map at once, so it does not go with {}; leave one of them out", other);
}

void report_alignment(const mapper::align::Aligner* aligner, const MappingOptions& options, mapper::RunReport& report) {
  if (aligner == nullptr) return;
  report.alignment = mapper::AlignmentReport{*mapper::align::odometry_mode_from_string(options.odometry),
                                             aligner->options().motion, aligner->report()};
}

hal::CameraModel camera_model(const board::Board& board) {
  return {.width_px = board.camera_width_px,
          .height_px = board.camera_height_px,
          .fx_px = static_cast<float>(board.camera_fx_px),
          .fy_px = static_cast<float>(board.camera_fy_px),
          .cx_px = static_cast<float>(board.camera_cx_px),
          .cy_px = static_cast<float>(board.camera_cy_px),
          .depth_units_per_metre = static_cast<float>(board.camera_depth_units_per_metre)};
}

hal::Result<std::optional<hal::FloorRectangle>> choose_rectangle(std::string_view option, const std::string& text) {
  if (text.empty()) return std::optional<hal::FloorRectangle>{};
  std::array<double, 4> corner{};
  std::size_t from = 0;
  std::size_t count = 0;
  for (; count < 4 && from <= text.size(); ++count) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const auto number = hal::parse_double(std::string_view(text).substr(from, comma - from));
    if (!number) break;
    corner[count] = *number;
    from = comma + 1;
  }
  if (count != 4 || from <= text.size() || corner[0] >= corner[2] || corner[1] >= corner[3]) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("{} '{}': not X0,Y0,X1,Y1 in metres with X0 < X1 and Y0 < Y1", option, text)};
  }
  return std::optional(hal::FloorRectangle{corner[0], corner[1], corner[2], corner[3]});
}

hal::Result<std::optional<mapper::StartFootprint>> start_footprint(const board::Board& board,
                                                                   const MappingOptions& options) {
  if (options.footprint.empty()) return std::optional<mapper::StartFootprint>{};
  mapper::StartFootprint footprint{board.robot_radius_m, board.robot_height_m, mount_pose(board)};
  if (options.footprint == "board") return std::optional(footprint);
  const std::size_t comma = options.footprint.find(',');
  const std::string_view text = options.footprint;
  if (comma != std::string::npos) {
    footprint.radius_m = hal::parse_double(text.substr(0, comma)).value_or(0.0);
    footprint.height_m = hal::parse_double(text.substr(comma + 1)).value_or(0.0);
  }
  const auto is_sensible = [](double m) { return m > 0.0 && m <= kLargestFootprint_m; };
  if (comma == std::string::npos || !is_sensible(footprint.radius_m) || !is_sensible(footprint.height_m)) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("--footprint '{}': not RADIUS,HEIGHT in metres, above 0 and up to {:g}, nor 'board'",
                                  options.footprint, kLargestFootprint_m)};
  }
  return std::optional(footprint);
}

}  // namespace g3d
