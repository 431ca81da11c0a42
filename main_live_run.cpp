// SPDX-License-Identifier: Apache-2.0
#include "main_live_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <utility>

#include "hal/linux/usb_serial.hpp"
#include "hal/sim/load_world.hpp"
#include "main_setup.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kLook_ns = 50'000'000;       // how often the main thread looks after the others
constexpr hal::TimeNs kProgress_ns = 500'000'000;  // between two lines for people
constexpr int kRenderThreads = 1;

std::atomic<bool> stop_requested{false};
std::atomic<int> stop_signals{0};

// The second one ends the program at once; then the guard sends the zeros.
void on_stop_signal(int) {
  if (stop_signals.fetch_add(1) > 0) _exit(130);
  stop_requested.store(true);
}

void catch_stop_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

hal::SimBuildingOptions building_options(const LiveOptions& options, const nav::RobotConfig& config) {
  hal::SimBuildingOptions building;
  building.camera = config.camera;
  building.noise = !options.no_noise;
  building.seed = options.mapping.seed;
  building.threads = kRenderThreads;
  hal::SimRobotOptions robot;
  robot.T_world_base = config.T_world_start;
  robot.T_base_camera = config.T_base_camera;
  robot.base.seed = options.mapping.seed;
  hal::add_drift(robot, options.drift, options.mapping.seed);
  building.robots = {robot};
  return building;
}

}  // namespace

hal::Result<Place> choose_place(const LiveOptions& options) {
  auto world = hal::load_world(options.world);
  if (!world) return world.error();
  const auto starts = hal::choose_starts(world.value(), 1, options.mapping.seed);
  if (!starts) return starts.error();
  auto observable = hal::find_observable(world.value(), starts.value());
  if (!observable) return observable.error();
  return Place{std::move(world).value(), starts.value()[0], std::move(observable).value()};
}

LiveRun::LiveRun(const board::Board& board, const LiveOptions& options, const nav::RobotConfig& config)
    : board_(board),
      options_(options),
      config_(config),
      port_({[this] { return find_port(); },
             [this](int fd) {
               if (guard_) (void)guard_->hand_over(fd);
             }},
            clock_),
      no_camera_(config.camera) {}

hal::Result<void> LiveRun::begin(std::optional<Place> place, double rate_hz) {
  catch_stop_signals();
  auto guard = hal::kobuki::LineGuard::start(-1);
  if (!guard) return guard.error();
  guard_.emplace(std::move(guard).value());
  if (place) {
    observable_ = std::move(place->observable);
    meter_.emplace(observable_);
    auto building = hal::RealTimeBuilding::start(std::move(place->world), building_options(options_, config_), clock_);
    if (!building) return building.error();
    building_ = std::move(building).value();
    sim_camera_ = std::make_unique<hal::RealTimeBuilding::Camera>(*building_, 0, rate_hz);
  }
  if (auto opened = port_.open(); !opened) return opened;
  if (auto files = begin_files(); !files) return files;
  nav::RobotParts parts{port_, camera(), clock_, [this] { end_camera(); }, &*guard_, recorder_.get(), {}};
  if (meter_) parts.coverage = [this](const nav::GroundMap& ground) { return meter_->fraction(ground.states()); };
  nav::RobotThreadsConfig threads;
  threads.robot = config_;
  robot_ = std::make_unique<nav::RobotThreads>(threads, parts);
  if (const auto missing = missing_card(robot_->mapper(), options_.mapping)) {
    return hal::Error{hal::Reason::unsupported, *missing};
  }
  return {};
}

hal::Result<void> LiveRun::begin_files() {
  const std::string& folder = options_.mapping.out_dir;
  if (folder.empty()) return {};
  if (options_.record) {
    auto recorder = hal::kobuki::LineRecorder::create(folder + "/kobuki.bin");
    if (!recorder) return recorder.error();
    recorder_ = std::move(recorder).value();
  }
  auto trajectory = hal::TrajectoryWriter::create(folder + "/trajectory.tum");
  if (!trajectory) return trajectory.error();
  trajectory_.emplace(std::move(trajectory).value());
  return {};
}

void LiveRun::run(bool show_progress) {
  show_progress = show_progress && isatty(STDERR_FILENO) != 0;
  const hal::TimeNs start_ns = clock_.now();
  const hal::TimeNs end_ns =
      options_.duration_s > 0.0 ? start_ns + static_cast<hal::TimeNs>(options_.duration_s * 1e9) : INT64_MAX;
  hal::TimeNs next_show_ns = start_ns;
  robot_->start();
  nav::LiveStatus status;
  while (!stop_requested.load() && clock_.now() < end_ns && !robot_->camera_has_ended()) {
    clock_.sleep_until(std::min(end_ns, clock_.now() + kLook_ns));
    save_poses();
    if (robot_->status().read(status) != 0 && status.state == nav::MissionState::home) break;
    if (show_progress && clock_.now() >= next_show_ns) {
      next_show_ns = clock_.now() + kProgress_ns;
      show(clock_.now() - start_ns, status);
    }
  }
  if (show_progress) fmt::print(stderr, "\n");
  robot_->stop();
  end_ns_ = clock_.now();
  run_s_ = static_cast<double>(end_ns_ - start_ns) / 1e9;
  save_poses();
  note_base();
}

void LiveRun::show(hal::TimeNs since_ns, const nav::LiveStatus& status) const {
  fmt::print(stderr, "\r{:6.0f} s", static_cast<double>(since_ns) / 1e9);
  if (meter_) fmt::print(stderr, "  {:5.1f} % seen", 100.0 * status.coverage);
  fmt::print(stderr, "  {:6.1f} m driven  {}     ", status.path_m, nav::name_of(status.state));
}

bool LiveRun::was_interrupted() const { return stop_requested.load(); }

std::optional<nav::OutsideView> LiveRun::outside() {
  if (building_ == nullptr) return std::nullopt;
  return building_->with(
      0, [](const hal::SimBuilding& building, const hal::PtyKobuki&) { return nav::outside_view(building.record(0)); });
}

double LiveRun::building_late_s() const {
  return building_ == nullptr ? 0.0 : static_cast<double>(building_->latest_step_ns()) / 1e9;
}

void LiveRun::finish_files(std::vector<hal::Error>& failures) {
  if (failure_) failures.push_back(*failure_);
  if (trajectory_) {
    if (const auto done = trajectory_->commit(); !done) failures.push_back(done.error());
  }
  if (recorder_ != nullptr) {
    if (const auto done = recorder_->finish(); !done) failures.push_back(done.error());
  }
}

hal::Result<std::string> LiveRun::find_port() {
  if (board_.base_line == "sim") return building_->path(0);
  if (board_.base_line != "auto") return board_.base_line;
  const auto found = hal::find_usb_serial({});
  if (!found) return found.error();
  return found.value().path;
}

hal::DepthCamera& LiveRun::camera() {
  if (sim_camera_ != nullptr) return *sim_camera_;
  return no_camera_;
}

void LiveRun::end_camera() {
  if (sim_camera_ != nullptr) sim_camera_->stop();
  no_camera_.stop();
}

void LiveRun::save_poses() {
  hal::StampedPose pose;
  while (robot_->next_pose(pose)) {
    poses_.push_back(pose.T_world_camera);
    if (!trajectory_) continue;
    if (const auto written = trajectory_->append(pose); !written && !failure_) failure_ = written.error();
  }
}

void LiveRun::note_base() {
  base_.line = port_.path();
  base_.low_latency = to_string(port_.low_latency());
  (void)robot_->base().state().read(base_.state);
  (void)robot_->base().health().read(base_.health);
  base_.refused_writes = base_.health.refused_writes;
  base_.guard_was_alive = guard_->alive();
  guard_.reset();  // with its own zeros
  base_.stands = base_.state.commanded == hal::Twist{};
  if (building_ != nullptr) {
    base_.stands = building_->with(0, [](hal::SimBuilding& building, hal::PtyKobuki&) {
      return building.kobuki(0).drive() == hal::kobuki::BaseControl{};
    });
  }
}

}  // namespace g3d
