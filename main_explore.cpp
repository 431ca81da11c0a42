// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --robots N`: a simulated building, a robot that explores it in lockstep, and what came out of it.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <utility>

#include "hal/clock.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/sim/disk_faults.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_commands.hpp"
#include "main_robot.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/block_source.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "mapper/version.hpp"
#include "nav/coverage.hpp"
#include "nav/exploration_report.hpp"
#include "nav/outputs.hpp"
#include "nav/robot.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;
constexpr double kLongest_s = 4.0 * 3600.0;  // no building of ours takes that long

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signals{0};

void on_stop_signal(int) {
  if (stop_signals.fetch_add(1) > 0) _exit(130);
  stop_requested.store(true);
}

void catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

/// What is said of a flight or of mapping and would be ignored here; empty: nothing.
std::string contradiction(const SimOptions& options) {
  const MappingOptions& mapping = options.mapping;
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

/// How far the robot is from where it believes to be, once a second: only a simulation can know.
struct PlaceError {
  double square_sum_m2 = 0.0;
  double largest_m = 0.0;
  double largest_turn_rad = 0.0;
  double last_m = 0.0;
  std::uint64_t count = 0;

  void note(const hal::PlanarPose& truth, const hal::PlanarPose& believed) {
    last_m = std::hypot(truth.x_m - believed.x_m, truth.y_m - believed.y_m);
    square_sum_m2 += last_m * last_m;
    largest_m = std::max(largest_m, last_m);
    largest_turn_rad = std::max(largest_turn_rad, std::abs(nav::wrap_angle(truth.heading_rad - believed.heading_rad)));
    ++count;
  }
  void write(mapper::JsonWriter& json) const {
    const auto rounded = [](double value) { return std::round(value * 1e4) / 1e4; };
    json.key("place_error").begin_object();
    json.member("rms_m", rounded(count > 0 ? std::sqrt(square_sum_m2 / static_cast<double>(count)) : 0.0));
    json.member("max_m", rounded(largest_m)).member("last_m", rounded(last_m));
    json.member("max_rad", rounded(largest_turn_rad)).end_object();
  }
};

/// The clock of one run: base packets and camera frames, each in its turn, until the robot is home.
class Exploration {
 public:
  Exploration(hal::SimBuilding& building, nav::Robot& robot, nav::CoverageMeter& coverage, nav::Hotline& hotline,
              const std::vector<nav::TimedWord>& words, double rate_hz, double limit_s, double pace)
      : building_(building),
        robot_(robot),
        coverage_(coverage),
        hotline_(hotline),
        words_(words),
        frame_period_ns_(static_cast<hal::TimeNs>(1e9 / rate_hz)),
        limit_ns_(static_cast<hal::TimeNs>(limit_s * 1e9)),
        pace_(pace),
        frame_(hal::make_frame(building.camera())) {}

  void run(bool show_progress) {
    const hal::TimeNs start_ns = real_.now();
    while (!stop_requested.load() && now_ns_ < limit_ns_ && !robot_.navigator().mission().is_over()) {
      now_ns_ = std::min(next_line_ns_, next_frame_ns_);
      if (pace_ > 0.0) {
        real_.sleep_until(start_ns + static_cast<hal::TimeNs>(static_cast<double>(now_ns_) / pace_));
      }
      building_.advance_to(now_ns_);
      if (now_ns_ == next_line_ns_) {
        hear();
        robot_.on_line(building_.line(0), now_ns_);
        next_line_ns_ += hal::kobuki::kPacketPeriod_ns;
      }
      if (now_ns_ == next_frame_ns_) take_frame();
      if (now_ns_ >= next_sample_ns_) {
        sample();
        if (show_progress && isatty(STDERR_FILENO) != 0) show(start_ns);
      }
    }
    if (show_progress && isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\n");
    sample();
  }

  [[nodiscard]] hal::TimeNs now_ns() const { return now_ns_; }
  [[nodiscard]] const PlaceError& place_error() const { return place_error_; }
  /// Of the integrated frames.
  [[nodiscard]] std::vector<hal::StampedPose> way() const { return corrected(way_, robot_.loops()); }

 private:
  void take_frame() {
    building_.render(0, frame_);
    frame_.stamp_ns = now_ns_;
    const std::uint64_t before = robot_.frames().integrated;
    if (building_.pass_on(0, frame_, now_ns_)) robot_.on_frame(frame_, now_ns_);
    if (robot_.frames().integrated != before) way_.push_back({frame_.stamp_ns, *robot_.last_frame_pose()});
    ++frames_;
    next_frame_ns_ = static_cast<hal::TimeNs>(frames_) * frame_period_ns_ / kStep_ns * kStep_ns;
  }

  /// People's words, and a script's.
  void hear() {
    for (; next_word_ < words_.size() && words_[next_word_].at_ns <= now_ns_; ++next_word_) {
      (void)hotline_.say(words_[next_word_].word);
    }
    bool is_news = now_ns_ >= next_status_ns_;
    while (const auto word = hotline_.take()) {
      if (const auto event = nav::event_of(*word)) robot_.navigator().command(*event);
      if (*word == nav::PersonWord::resume) (void)robot_.driver().resume();
      is_news = true;
    }
    if (!is_news) return;
    nav::LiveStatus status = robot_.status(now_ns_);
    status.coverage = fraction_;
    hotline_.publish(status);
    next_status_ns_ = now_ns_ + kStatus_ns;
  }

  void sample() {
    place_error_.note(building_.T_world_base(0), robot_.T_world_base());
    fraction_ = coverage_.fraction(robot_.navigator().ground().states());
    robot_.navigator().report().note_coverage(fraction_, now_ns_);
    next_sample_ns_ = now_ns_ + kSecond_ns;
  }

  void show(hal::TimeNs start_ns) const {
    const double simulated_s = static_cast<double>(now_ns_) / 1e9;
    const double real_s = std::max(1e-3, static_cast<double>(real_.now() - start_ns) / 1e9);
    fmt::print(stderr, "\r{:6.0f} s  {:5.1f} % seen  {:6.1f} m driven  {:5.1f} x real time  {}   ", simulated_s,
               100.0 * fraction_, robot_.navigator().report().path_m, simulated_s / real_s,
               nav::name_of(robot_.navigator().mission().state()));
  }

  static constexpr hal::TimeNs kStatus_ns = 200'000'000;
  static inline const hal::TimeNs kStep_ns = hal::SimBuildingOptions{}.step_ns;
  hal::SimBuilding& building_;
  nav::Robot& robot_;
  nav::CoverageMeter& coverage_;
  nav::Hotline& hotline_;
  const std::vector<nav::TimedWord>& words_;
  std::size_t next_word_ = 0;
  hal::TimeNs next_status_ns_ = 0;
  hal::RealClock real_;
  hal::TimeNs frame_period_ns_;
  hal::TimeNs limit_ns_;
  double pace_;
  hal::Frame frame_;
  hal::TimeNs now_ns_ = 0;
  hal::TimeNs next_line_ns_ = 0;
  hal::TimeNs next_frame_ns_ = 0;
  hal::TimeNs next_sample_ns_ = 0;
  std::uint64_t frames_ = 0;
  double fraction_ = 0.0;
  PlaceError place_error_;
  std::vector<hal::StampedPose> way_;
};

}  // namespace

int run_explore(const SimOptions& options, const std::string& command_line) {
  const MappingOptions& mapping = options.mapping;
  if (const std::string problem = contradiction(options); !problem.empty()) return bad_usage(problem);
  const auto loaded_board = effective_board(mapping);
  if (!loaded_board) return fail(loaded_board.error().text);
  const board::Board& board = loaded_board.value();
  if (const auto problem = loops_problem(mapping)) return bad_usage(*problem);
  const auto camera = choose_camera(board, options.camera);
  if (!camera) return bad_usage(camera.error().text);
  const std::string world_name = options.world == "builtin" ? "furnished_room" : options.world;
  const auto crop = choose_rectangle("--crop", options.crop);
  if (!crop) return bad_usage(crop.error().text);
  auto world = hal::load_world(world_name, crop.value());
  if (!world)
    return world.error().reason == hal::Reason::bad_usage ? bad_usage(world.error().text) : fail(world.error().text);
  const auto starts = hal::choose_starts(world.value(), 1, mapping.seed);
  if (!starts) return fail(starts.error().text);
  const auto observable = hal::find_observable(world.value(), starts.value());
  if (!observable) return fail(observable.error().text);

  const auto staging = read_staging(options.staging);
  if (!staging) return bad_usage(staging.error().text);
  nav::RobotConfig config = robot_config(board, mapping, camera.value().model, starts.value()[0]);
  if (config.loops) config.loops->is_lockstep = true;  // the same seed, the same way
  if (const auto area = set_area(options.area, config.navigator.explorer); !area) return bad_usage(area.error().text);
  if (const auto problem = mapper::config_problem(config.mapper, config.camera)) return fail(*problem);
  if (const auto folder = open_folder(mapping.out_dir); !folder) return fail(folder.error().text);

  hal::SimBuildingOptions building_options;
  building_options.camera = config.camera;
  building_options.noise = !options.no_noise;
  building_options.seed = mapping.seed;
  building_options.threads = board.map_threads;
  hal::SimRobotOptions robot_options;
  robot_options.T_world_base = starts.value()[0];
  robot_options.T_base_camera = config.T_base_camera;
  robot_options.base.seed = mapping.seed;
  hal::add_drift(robot_options, options.drift, mapping.seed, drift_like(options.drift_like));
  set_battery(robot_options.base, options.staging);
  building_options.robots = {robot_options};
  building_options.faults = staging.value().faults;
  hal::SimBuilding building(std::move(world).value(), building_options);
  hal::RealClock clock;
  nav::Robot robot(config, clock);
  if (const auto missing = missing_card(robot.mapper(), mapping)) return fail(*missing);
  nav::CoverageMeter coverage(observable.value());
  catch_stop_signals();
  nav::Hotline hotline;
  std::unique_ptr<hal::ControlSocket> control;
  if (mapping.rate > 0.0 || !options.staging.control.empty()) {  // else it is over before anybody has said a word
    auto opened = open_control(options.staging, mapping.out_dir, hotline);
    if (!opened) return fail(opened.error().text);
    control = std::move(opened).value();
  }
  const double limit_s = options.duration_s > 0.0 ? options.duration_s : kLongest_s;
  const double rate_hz = options.frame_rate_hz.value_or(camera.value().rate_hz);
  Exploration exploration(building, robot, coverage, hotline, staging.value().words, rate_hz, limit_s, mapping.rate);
  const hal::TimeNs start_ns = clock.now();
  // A disk's faults go by simulated time, and by the real one while what was mapped is saved.
  hal::TimeNs end_ns = 0;
  const auto disk_time = [&] { return exploration.now_ns() + (end_ns > 0 ? clock.now() - end_ns : 0); };
  hal::DiskFaults bad_disk(staging.value().faults, disk_time);
  const hal::DiskInstead disk_instead(bad_disk);
  exploration.run(!mapping.quiet);
  end_ns = clock.now();
  robot.finish_map();
  const double run_s = static_cast<double>(clock.now() - start_ns) / 1e9;

  const nav::Mission& mission = robot.navigator().mission();
  nav::ExplorationReport explored;
  explored.mission = &robot.navigator().report();
  explored.time_s = robot.navigator().report().time_s(exploration.now_ns());
  explored.home = mission.is_over();
  explored.state = nav::name_of(mission.state());
  explored.outside = nav::outside_view(building.record(0));
  explored.safety_stops = safety_stops(robot.base());
  const std::vector<hal::StampedPose> way = exploration.way();
  const std::vector<hal::Pose> poses = poses_of(way);
  RunFiles files;
  files.folder = mapping.out_dir;
  files.patience_s = mapping.patience_s;
  files.way = way;
  files.map = &robot.mapper().map();
  files.options.trajectory = poses;
  files.options.band = {static_cast<float>(board.ground_low_m), static_cast<float>(board.ground_high_m)};
  files.options.meta.steps = config.mapper.steps;
  files.draw = [&](const std::string& path) {
    return write_picture(explored, robot.navigator(), poses, std::filesystem::path(world_name).stem().string(), path);
  };
  files.is_given_up = [was = stop_requested.load()] { return !was && stop_requested.load(); };
  nav::Outputs outputs = save_run(files);
  mapper::RunReport report;
  report.frames = robot.frames();
  report.stages = {{"integrate", robot.integrate_times()}, {"navigate", robot.navigate_times()}};
  if (robot.placing().aligner() != nullptr) report.stages.push_back({"align", robot.align_times()});
  report.resolution_m = board.map_resolution_m;
  const mapper::MapCounts counts = robot.mapper().map().counts();
  report.occupied = counts.occupied;
  report.free = counts.free;
  report.memory_bytes = robot.mapper().map().memory().used_bytes;
  report.refused_blocks = robot.refused_blocks();
  report.file_bytes = outputs.map_file_bytes;
  report.hash = mapper::map_hash(robot.mapper().map());
  report_mapper(robot.mapper(), report);
  report_alignment(robot.placing().aligner(), mapping, report);
  if (robot.loops() != nullptr) {
    report.stages.push_back({"loops", robot.loops_times()});
    report.loops = robot.loops()->report();
  }
  report.command = command_line;
  report.version = mapper::version();
  report.seed = mapping.seed;
  report.threads = board.map_threads;
  report.board = board.name;
  const hal::ControlCounts control_counts = control != nullptr ? control->counts() : hal::ControlCounts{};
  control.reset();
  report.write_more = [&](mapper::JsonWriter& json) {
    nav::write_exploration(json, explored);
    exploration.place_error().write(json);
    write_control(json, hotline, control_counts);
  };
  if (stop_requested.load()) report.notes.emplace_back("interrupted: what was mapped until then is saved");
  if (robot.pool_full_frames() > 0) {
    report.notes.push_back(fmt::format("the map's memory was full for {} frames and took no new blocks; raise --memory",
                                       robot.pool_full_frames()));
  }
  if (outputs.late_files > 0) report.notes.push_back(late_files_note(outputs.late_files));
  const std::string json = to_json(report);
  save_report(files, json, outputs);
  if (mapping.json) {
    fmt::print("{}", json);
  } else if (!mapping.quiet) {
    fmt::print("{}{}", nav::exploration_text(explored), summary_text(report, run_s, outputs.files));
  }
  for (const hal::Error& failure : outputs.failures) (void)fail(failure.text);
  return outputs.failures.empty() ? kExitDone : kExitFailed;
}

}  // namespace g3d
