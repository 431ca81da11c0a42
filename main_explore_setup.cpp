// SPDX-License-Identifier: Apache-2.0
#include "main_explore.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <utility>

#include "hal/sim/load_world.hpp"
#include "hal/sim/reach.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/version.hpp"

namespace g3d {
namespace {

constexpr double kLongest_s = 4.0 * 3600.0;  // no building of ours takes that long

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signals{0};

// The second one ends the program at once; then a real base's guard sends the zeros.
void on_stop_signal(int) {
  if (stop_signals.fetch_add(1) > 0) _exit(130);
  stop_requested.store(true);
}

/// What is said of one robot alone and would be ignored where there are several; empty: nothing.
std::string team_contradiction(const SimOptions& options) {
  if (options.mapping.rate > 0.0) return "--rate goes with one robot only so far; leave it out";
  if (!options.staging.at.empty() || !options.staging.control.empty()) {
    return "--at and --control speak to one robot; leave them out where there are several";
  }
  return {};
}

/// What is said of a flight or of mapping and would be ignored here; empty: nothing.
std::string contradiction(const SimOptions& options) {
  const MappingOptions& mapping = options.mapping;
  if (options.robots > 1) {
    if (const std::string problem = team_contradiction(options); !problem.empty()) return problem;
  } else if (!options.cuts.empty() || !options.deaths.empty()) {
    return "--partition and --kill are of teams; give --robots 2 or more";
  } else if (options.loss > 0.0 || options.radio_range_m > 0.0) {
    return "--loss and --radio-range are of the radio between robots; give --robots 2 or more";
  }
  if (options.camera_path != "builtin") return "--robots and --camera-path: give one of them";
  if (options.laps != 1) return "--laps is for a camera path, not for --robots";
  if (!options.camera.empty() && options.frame_rate_hz)
    return "--camera and --fps both give the rate: give one of them";
  if (mapping.mode && *mapping.mode == "static") {
    return "--mode static knows no free space, so no robot can drive by it; leave it out";
  }
  if (mapping.window_m || mapping.checkpoint_s > 0.0) {
    return "--window and --checkpoint do not go with --robots yet; leave them out";
  }
  if (!mapping.mask_path.empty()) return "--mask does not go with --robots yet; leave it out";
  if (mapping.odometry == "none") return "--odometry none: a robot's base measures motion; take given or aligned";
  if (mapping.motion == "free") return "--motion free is for hand-held cameras, not for --robots";
  if (!mapping.footprint.empty()) return "--footprint: robots take their own from the board; leave it out";
  return {};
}

}  // namespace

void catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

bool is_stop_requested() { return stop_requested.load(); }

void PlaceError::write(mapper::JsonWriter& json) const {
  const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
  json.key("place_error").begin_object();
  json.member("rms_m", rounded(count > 0 ? std::sqrt(square_sum_m2 / static_cast<double>(count)) : 0.0));
  json.member("max_m", rounded(largest_m)).member("last_m", rounded(last_m));
  json.member("max_rad", rounded(largest_turn_rad)).end_object();
}

int prepare_exploration(const SimOptions& options, ExploreSetup& setup) {
  const MappingOptions& mapping = options.mapping;
  if (const std::string problem = contradiction(options); !problem.empty()) return bad_usage(problem);
  auto board = effective_board(mapping);
  if (!board) return fail(board.error().text);
  setup.board = std::move(board).value();
  if (const auto problem = loops_problem(mapping)) return bad_usage(*problem);
  const auto camera = choose_camera(setup.board, options.camera);
  if (!camera) return bad_usage(camera.error().text);
  setup.rate_hz = options.frame_rate_hz.value_or(camera.value().rate_hz);
  setup.limit_s = options.duration_s > 0.0 ? options.duration_s : kLongest_s;
  const std::string world_name = options.world == "builtin" ? "furnished_room" : options.world;
  setup.place = std::filesystem::path(world_name).stem().string();
  const auto crop = choose_rectangle("--crop", options.crop);
  if (!crop) return bad_usage(crop.error().text);
  auto world = hal::load_world(world_name, crop.value());
  if (!world) {
    return world.error().reason == hal::Reason::bad_usage ? bad_usage(world.error().text) : fail(world.error().text);
  }
  setup.world = std::move(world).value();
  const auto starts = hal::choose_starts(setup.world, static_cast<std::size_t>(options.robots), mapping.seed);
  if (!starts) return fail(starts.error().text);
  auto observable = hal::find_observable(setup.world, starts.value());
  if (!observable) return fail(observable.error().text);
  setup.observable = std::move(observable).value();
  auto staging = read_staging(options.staging);
  if (!staging) return bad_usage(staging.error().text);
  setup.staging = std::move(staging).value();

  setup.building.noise = !options.no_noise;
  setup.building.seed = mapping.seed;
  setup.building.threads = setup.board.map_threads;
  setup.building.faults = setup.staging.faults;
  for (std::size_t i = 0; i < starts.value().size(); ++i) {
    nav::RobotConfig config = robot_config(setup.board, mapping, camera.value().model, starts.value()[i]);
    if (config.loops) config.loops->is_lockstep = true;  // the same seed, the same way
    if (const auto area = set_area(options.area, config.navigator.explorer); !area) return bad_usage(area.error().text);
    if (const auto problem = mapper::config_problem(config.mapper, config.camera)) return fail(*problem);
    // Each base drifts in its own way.
    const std::uint64_t seed = mapping.seed + 1000 * i;
    hal::SimRobotOptions robot;
    robot.T_world_base = starts.value()[i];
    robot.T_base_camera = config.T_base_camera;
    robot.base.seed = seed;
    hal::add_drift(robot, options.drift, seed, drift_like(options.drift_like));
    set_battery(robot.base, options.staging);
    setup.building.robots.push_back(robot);
    setup.building.camera = config.camera;
    setup.configs.push_back(std::move(config));
  }
  if (const auto folder = open_folder(mapping.out_dir); !folder) return fail(folder.error().text);
  return kExitDone;
}

nav::ExplorationReport explored_by(const nav::Robot& robot, const hal::RobotRecord& record, hal::TimeNs end_ns) {
  const nav::Mission& mission = robot.navigator().mission();
  nav::ExplorationReport explored;
  explored.mission = &robot.navigator().report();
  explored.time_s = robot.navigator().report().time_s(end_ns);
  explored.home = mission.is_over();
  explored.state = nav::name_of(mission.state());
  explored.outside = nav::outside_view(record);
  explored.safety_stops = safety_stops(robot.base());
  return explored;
}

mapper::RunReport report_of(const nav::Robot& robot, const SimOptions& options, const board::Board& board,
                            const nav::Outputs& outputs, const std::string& command_line) {
  mapper::RunReport report;
  report.frames = robot.frames();
  report.stages = {{"integrate", robot.integrate_times()}, {"navigate", robot.navigate_times()}};
  if (robot.placing().aligner() != nullptr) report.stages.push_back({"align", robot.align_times()});
  report.resolution_m = board.map_resolution_m;
  report_map(robot.mapper(), report);
  report.refused_blocks = robot.refused_blocks();
  report.file_bytes = outputs.map_file_bytes;
  report_alignment(robot.placing().aligner(), options.mapping, report);
  if (robot.loops() != nullptr) {
    report.stages.push_back({"loops", robot.loops_times()});
    report.loops = robot.loops()->report();
  }
  report.command = command_line;
  report.version = mapper::version();
  report.seed = options.mapping.seed;
  report.threads = board.map_threads;
  report.board = board.name;
  if (is_stop_requested()) report.notes.emplace_back("interrupted: what was mapped until then is saved");
  if (robot.pool_full_frames() > 0) {
    report.notes.push_back(fmt::format("the map's memory was full for {} frames and took no new blocks; raise --memory",
                                       robot.pool_full_frames()));
  }
  if (outputs.late_files > 0) report.notes.push_back(late_files_note(outputs.late_files));
  return report;
}

}  // namespace g3d
