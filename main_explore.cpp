// SPDX-License-Identifier: Apache-2.0
// `g3dmap sim --robots 1`: a simulated building, a robot that explores it in lockstep, and what came out of it.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "hal/clock.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/sim/disk_faults.hpp"
#include "hal/sim/sim_building.hpp"
#include "main_commands.hpp"
#include "main_explore.hpp"
#include "main_robot.hpp"
#include "main_save.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/report.hpp"
#include "mapper/summary.hpp"
#include "nav/coverage.hpp"
#include "nav/exploration_report.hpp"
#include "nav/outputs.hpp"
#include "nav/robot.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kExploringSecond_ns = 1'000'000'000;

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
    while (!is_stop_requested() && now_ns_ < limit_ns_ && !robot_.navigator().mission().is_over()) {
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
    next_sample_ns_ = now_ns_ + kExploringSecond_ns;
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
  ExploreSetup setup;
  if (const int code = prepare_exploration(options, setup); code != kExitDone) return code;
  const nav::RobotConfig& config = setup.configs[0];
  hal::SimBuilding building(std::move(setup.world), setup.building);
  hal::RealClock clock;
  nav::Robot robot(config, clock);
  if (const auto missing = missing_card(robot.mapper(), mapping)) return fail(*missing);
  nav::CoverageMeter coverage(setup.observable);
  catch_stop_signals();
  nav::Hotline hotline;
  std::unique_ptr<hal::ControlSocket> control;
  if (mapping.rate > 0.0 || !options.staging.control.empty()) {  // else it is over before anybody has said a word
    auto opened = open_control(options.staging, mapping.out_dir, hotline);
    if (!opened) return fail(opened.error().text);
    control = std::move(opened).value();
  }
  Exploration exploration(building, robot, coverage, hotline, setup.staging.words, setup.rate_hz, setup.limit_s,
                          mapping.rate);
  const hal::TimeNs start_ns = clock.now();
  // A disk's faults go by simulated time, and by the real one while what was mapped is saved.
  hal::TimeNs end_ns = 0;
  const auto disk_time = [&] { return exploration.now_ns() + (end_ns > 0 ? clock.now() - end_ns : 0); };
  hal::DiskFaults bad_disk(setup.staging.faults, disk_time);
  const hal::DiskInstead disk_instead(bad_disk);
  exploration.run(!mapping.quiet);
  end_ns = clock.now();
  robot.finish_map();
  const double run_s = static_cast<double>(clock.now() - start_ns) / 1e9;

  const nav::ExplorationReport explored = explored_by(robot, building.record(0), exploration.now_ns());
  const std::vector<hal::StampedPose> way = exploration.way();
  const std::vector<hal::Pose> poses = poses_of(way);
  RunFiles files;
  files.folder = mapping.out_dir;
  files.patience_s = mapping.patience_s;
  files.way = way;
  files.map = &robot.mapper().map();
  files.options.trajectory = poses;
  files.options.band = {static_cast<float>(setup.board.ground_low_m), static_cast<float>(setup.board.ground_high_m)};
  files.options.meta.steps = config.mapper.steps;
  files.draw = [&](const std::string& path) {
    return write_picture(explored, robot.navigator(), poses, setup.place, path);
  };
  files.is_given_up = [was = is_stop_requested()] { return !was && is_stop_requested(); };
  nav::Outputs outputs = save_run(files);
  mapper::RunReport report = report_of(robot, options, setup.board, outputs, command_line);
  const hal::ControlCounts control_counts = control != nullptr ? control->counts() : hal::ControlCounts{};
  control.reset();
  report.write_more = [&](mapper::JsonWriter& json) {
    nav::write_exploration(json, explored);
    exploration.place_error().write(json);
    write_control(json, hotline, control_counts);
  };
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
