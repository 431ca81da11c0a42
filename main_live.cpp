// SPDX-License-Identifier: Apache-2.0
// `g3dmap run`: the board's robot in real time. Its base is at a serial port, found or named, or at a pseudo-terminal
// of a building that is simulated in this process; everything on this side of the line is the same.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "hal/linux/heap_room.hpp"
#include "main_commands.hpp"
#include "main_kinect.hpp"
#include "main_live_run.hpp"
#include "main_network.hpp"
#include "main_robot.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/exploration_report.hpp"
#include "nav/outputs.hpp"

namespace g3d {
namespace {

constexpr std::size_t kHeapRoom_bytes = std::size_t{192} << 20;  // what a robot of 100 m by 100 m takes of the heap

std::optional<std::string> contradiction(const board::Board& board, const LiveOptions& options) {
  const bool in_simulation = board.base_line == "sim";
  const bool may_be_shown = in_simulation && is_kinect(board);
  if (board.camera_source.starts_with(kOniSource) && !in_simulation) {
    return fmt::format(
        "{}: camera.source = \"{}\": a real base does not drive by what somebody else saw; use "
        "`g3dmap replay`, or base.line = \"sim\"",
        options.mapping.board_path, board.camera_source);
  }
  if (is_kinect(board) && !options.camera.empty())
    return "--camera is for a simulated one; a Kinect has 640x480 at 30 Hz";
  if (!options.oni_path.empty() && board.camera_source != "kinect") {
    return "--record-oni needs a Kinect: camera.source = \"kinect\" in the board file";
  }
  if (!may_be_shown && in_simulation != (board.camera_source == "sim")) {
    return fmt::format(
        "{}: base.line = \"{}\" and camera.source = \"{}\" do not go together: a simulated camera sees "
        "only the building of a simulated base",
        options.mapping.board_path, board.base_line, board.camera_source);
  }
  const bool in_stream = board.camera_source.starts_with(kStreamSource);
  if (!in_simulation && !in_stream && !options.camera.empty())
    return "--camera is for a simulated one; set [camera] in the board file";
  if (!in_stream && options.slow > 1.0) return "--slow is for the camera of a `g3dmap building`";
  const bool fails_in_simulation = std::any_of(options.staging.fail.begin(), options.staging.fail.end(),
                                               [](const std::string& fault) { return !fault.starts_with("disk:"); });
  if (!in_simulation && fails_in_simulation) return "--fail: only the disk of a real robot can be made to fail";
  if (!in_simulation && options.staging.battery_min > 0.0) return "--battery is for a simulated base";
  if (!in_simulation && !options.start.empty()) return "--start is for a simulated building";
  if (options.mapping.checkpoint_s > 0.0) return "--checkpoint is for a base station; a robot saves at the end";
  if (options.mapping.loops && board.network_keep != "none") {
    return "--loops numbers the submaps that a robot shares by its way, --keep by its starts; leave one of them out";
  }
  if (options.record.starts_with('-')) return "--record needs the name of a new folder after it";
  if (!options.record.empty() && options.record == options.mapping.out_dir) {
    return "--record and --out need a folder each: both have a trajectory.tum";
  }
  if (auto problem = loops_problem(options.mapping)) return problem;
  if (board.map_mode == "static") return "map.mode \"static\" knows no free space, so no robot can drive by it";
  return std::nullopt;
}

mapper::RunReport make_report(LiveRun& live, const board::Board& board, const LiveOptions& options,
                              const std::string& command_line) {
  const nav::RobotThreads& robot = live.robot();
  mapper::RunReport report;
  report.frames = robot.frames();
  report.stages = robot.stages();
  report.resolution_m = board.map_resolution_m;
  report_map(robot.mapper(), report);
  report.refused_blocks = robot.refused_blocks();
  report_alignment(robot.placing().aligner(), options.mapping, report);
  if (robot.loops() != nullptr) report.loops = robot.loops()->report();
  report.command = command_line;
  report.version = mapper::version();
  report.seed = options.mapping.seed;
  report.threads = board.map_threads;
  report.board = board.name;
  const auto note = [&](std::uint64_t count, const char* text) {
    if (count > 0) report.notes.push_back(fmt::format("{} {}", count, text));
  };
  if (live.was_interrupted()) report.notes.emplace_back("interrupted: what was mapped until then is saved");
  note(robot.pool_full_frames(), "frames found the map's memory full; raise --memory");
  note(robot.lost_poses(), "poses are missing in trajectory.tum: writing it was too slow");
  note(live.unrecorded_bytes(), "bytes of the base are missing in kobuki.bin: the disk was too slow, or full");
  if (live.fleet() != nullptr) {
    if (std::string warning = live.fleet()->warning(); !warning.empty()) report.notes.push_back(std::move(warning));
  }
  for (const std::string& text : live.buses().notes()) report.notes.push_back(text);
  live.end_recording(report.hash);
  if (const std::string error = live.camera_error(); !error.empty()) report.notes.push_back(error);
  if (live.kinect() != nullptr) {
    for (std::string& text : live.kinect()->notes()) report.notes.push_back(std::move(text));
  }
  if (live.building_late_s() > 0.1) {
    report.notes.push_back(fmt::format("this machine was too busy: the simulated building was up to {:.0f} ms late",
                                       1e3 * live.building_late_s()));
  }
  return report;
}

/// The map of the whole fleet, as this robot has it, in a folder of its own; the files take their place among the rest.
void save_merged(const RunFiles& own, const mapper::VoxelMap& merged, nav::Outputs& outputs) {
  RunFiles files;
  files.folder = own.folder + "/merged";
  files.patience_s = own.patience_s;
  files.map = &merged;
  files.options.band = own.options.band;
  files.options.meta.steps = own.options.meta.steps;
  files.is_given_up = own.is_given_up;
  if (const auto folder = open_folder(files.folder); !folder) {
    outputs.failures.push_back(folder.error());
    return;
  }
  const nav::Outputs saved = save_run(files);
  outputs.files.insert(outputs.files.end(), saved.files.begin(), saved.files.end());
  outputs.failures.insert(outputs.failures.end(), saved.failures.begin(), saved.failures.end());
  outputs.late_files += saved.late_files;
}

}  // namespace

int run_live(const LiveOptions& options, const std::string& command_line) {
  const MappingOptions& mapping = options.mapping;
  auto loaded_board = effective_board(mapping);
  if (!loaded_board) return fail(loaded_board.error().text);
  if (loaded_board.value().base_line == "none") return run_station(options, command_line);
  if (const auto said = set_network(options.network, loaded_board.value()); !said) return bad_usage(said.error().text);
  const board::Board& board = loaded_board.value();
  if (const auto problem = contradiction(board, options)) return bad_usage(*problem);
  (void)hal::make_heap_room(kHeapRoom_bytes);  // without it the start takes longer
  std::unique_ptr<KinectPart> kinect;
  if (is_kinect(board)) {
    auto opened = KinectPart::open(loaded_board.value(), options.oni_path);
    if (!opened) return fail_as(opened.error());
    kinect = std::move(opened).value();
  }
  const auto camera = choose_camera(board, options.camera);
  if (!camera) return bad_usage(camera.error().text);
  std::optional<FleetPlan> fleet;
  if (has_fleet(board)) {
    auto plan = plan_fleet(board, true, mapping.loops);
    if (!plan) return fail_as(plan.error());
    fleet = std::move(plan).value();
  }
  std::optional<Place> place;
  if (board.base_line == "sim") {
    auto chosen = choose_place(options);
    if (!chosen) return fail_as(chosen.error());
    place = std::move(chosen).value();
  }
  nav::RobotConfig config =
      robot_config(board, mapping, camera.value().model, place ? place->T_world_start : hal::PlanarPose{});
  if (const auto area = set_area(options.area, config.navigator.explorer); !area) return bad_usage(area.error().text);
  if (const auto problem = mapper::config_problem(config.mapper, config.camera)) return fail(*problem);
  if (!mapping.out_dir.empty()) {
    if (const auto folder = open_folder(mapping.out_dir); !folder) return fail(folder.error().text);
  }

  const auto staging = read_staging(options.staging);
  if (!staging) return bad_usage(staging.error().text);
  LiveRun live(board, options, config, staging.value());
  live.use(std::move(kinect));
  if (const auto begun = live.begin(std::move(place), camera.value().rate_hz, std::move(fleet)); !begun) {
    return fail_as(begun.error());
  }
  live.run(!mapping.quiet);

  const nav::Navigator& navigator = live.robot().navigator();
  nav::ExplorationReport explored;
  explored.mission = &navigator.report();
  explored.time_s = navigator.report().time_s(live.end_ns());
  explored.home = navigator.mission().is_over();
  explored.state = nav::name_of(navigator.mission().state());
  explored.outside = live.outside();
  explored.safety_stops = safety_stops(live.base().state);
  nav::Outputs outputs;
  RunFiles files;
  const std::vector<hal::StampedPose> way = corrected(live.way(), live.robot().loops());
  const std::vector<hal::Pose> poses = poses_of(way);
  if (!mapping.out_dir.empty()) {
    files.folder = mapping.out_dir;
    files.patience_s = mapping.patience_s;
    files.way = way;
    files.map = &live.robot().mapper().map();
    files.options.trajectory = poses;
    files.options.band = {static_cast<float>(board.ground_low_m), static_cast<float>(board.ground_high_m)};
    files.options.meta.steps = config.mapper.steps;
    const std::string place_name =
        board.base_line == "sim" ? std::filesystem::path(options.world).stem().string() : board.name;
    files.draw = [&, place_name](const std::string& path) {
      return write_picture(explored, navigator, poses, place_name, path);
    };
    files.is_given_up = [&live, was = live.was_interrupted()] { return !was && live.was_interrupted(); };
    files.finish_recording = [&live] { return live.finish_recording(); };
    outputs = save_run(files);
  } else if (const auto recorded = live.finish_recording(); !recorded) {
    outputs.failures.push_back(recorded.error());
  }
  const std::unique_ptr<net::MergedMap> merged = live.fleet() != nullptr ? live.fleet()->whole_map() : nullptr;
  if (merged != nullptr && !mapping.out_dir.empty()) save_merged(files, merged->map(), outputs);
  mapper::RunReport report = make_report(live, board, options, command_line);
  report.write_more = [&](mapper::JsonWriter& json) {
    nav::write_exploration(json, explored);
    if (merged != nullptr) live.fleet()->write(json, mapper::map_hash(merged->map()), live.run_s());
    write_base(json, live.base());
    live.buses().write(json);
    live.write_control(json);
    live.write_camera(json);
    live.write_recording(json);
    if (live.kinect() != nullptr) live.kinect()->write(json);
    write_cpu(json, live.thread_times(), live.run_s());
  };
  report.file_bytes = outputs.map_file_bytes;
  if (outputs.late_files > 0) report.notes.push_back(late_files_note(outputs.late_files));
  const std::string json = to_json(report);
  if (!mapping.out_dir.empty()) save_report(files, json, outputs);
  if (mapping.json) {
    fmt::print("{}", json);
  } else if (!mapping.quiet) {
    fmt::print("{}{}", nav::exploration_text(explored), summary_text(report, live.run_s(), outputs.files));
  }
  for (const hal::Error& failure : outputs.failures) (void)fail(failure.text);
  return outputs.failures.empty() ? kExitDone : kExitFailed;
}

}  // namespace g3d
