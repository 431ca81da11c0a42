// SPDX-License-Identifier: Apache-2.0
#include "main_live_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>

#include "hal/linux/cpu_time.hpp"
#include "hal/linux/usb_serial.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/reach.hpp"
#include "main_building.hpp"
#include "main_explore.hpp"
#include "main_setup.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kLiveLook_ns = 50'000'000;   // how often the main thread looks after the others
constexpr hal::TimeNs kProgress_ns = 500'000'000;  // between two lines for people
constexpr int kRenderThreads = 1;
constexpr int kMostStarts = 16;
constexpr double kSettle_s = 10.0;
constexpr double kHurriedSettle_s = 3.0;

hal::SimBuildingOptions building_options(const LiveOptions& options, const nav::RobotConfig& config,
                                         const hal::FaultPlan& faults) {
  hal::SimBuildingOptions building;
  building.camera = config.camera;
  building.noise = !options.no_noise;
  building.seed = options.mapping.seed;
  building.threads = kRenderThreads;
  hal::SimRobotOptions robot;
  robot.T_world_base = config.T_world_start;
  robot.T_base_camera = config.T_base_camera;
  robot.base.seed = options.mapping.seed;
  hal::add_drift(robot, options.drift, options.mapping.seed, drift_like(options.drift_like));
  set_battery(robot.base, options.staging);
  building.robots = {robot};
  building.faults = faults;
  return building;
}

/// The first, the one of that number, or a place that is given.
hal::Result<hal::PlanarPose> choose_start(const LiveOptions& options, const hal::World& world) {
  const std::string_view text = options.start;
  const std::size_t comma = text.find(',');
  const std::size_t second = comma == std::string_view::npos ? comma : text.find(',', comma + 1);
  if (second != std::string_view::npos) {
    const auto x_m = hal::parse_double(text.substr(0, comma));
    const auto y_m = hal::parse_double(text.substr(comma + 1, second - comma - 1));
    const auto turn_deg = hal::parse_double(text.substr(second + 1));
    if (x_m && y_m && turn_deg && std::abs(*turn_deg) <= 360.0) {
      if (!hal::fits(hal::FloorContact(world), *x_m, *y_m, {})) {
        return hal::Error{hal::Reason::bad_usage, fmt::format("--start {}: a robot does not fit there", options.start)};
      }
      return hal::PlanarPose{*x_m, *y_m, *turn_deg * std::numbers::pi / 180.0};
    }
  } else if (const auto number = hal::parse_double(text.empty() ? "1" : text);
             number && *number >= 1 && *number <= kMostStarts && *number == std::floor(*number)) {
    const auto starts = hal::choose_starts(world, static_cast<std::size_t>(*number), options.mapping.seed);
    if (!starts) return starts.error();
    return starts.value().back();
  }
  return hal::Error{hal::Reason::bad_usage, fmt::format("--start '{}': not a number from 1 to {}, nor X,Y,DEGREES",
                                                        options.start, kMostStarts)};
}

}  // namespace

hal::Result<Place> choose_place(const LiveOptions& options) {
  auto world = hal::load_world(options.world);
  if (!world) return world.error();
  const auto start = choose_start(options, world.value());
  if (!start) return start.error();
  auto observable = hal::find_observable(world.value(), std::vector{start.value()});
  if (!observable) return observable.error();
  return Place{std::move(world).value(), start.value(), std::move(observable).value()};
}

LiveRun::LiveRun(const board::Board& board, const LiveOptions& options, const nav::RobotConfig& config,
                 const Staging& staging)
    : board_(board),
      options_(options),
      config_(config),
      staging_(staging),
      clock_(static_cast<std::uint32_t>(std::lround(100.0 * options.slow))),
      port_({[this] { return find_port(); },
             [this](int fd) {
               if (guard_) (void)guard_->hand_over(fd);
             }},
            clock_),
      no_camera_(config.camera) {}

hal::Result<void> LiveRun::begin(std::optional<Place> place, double rate_hz, std::optional<FleetPlan> fleet) {
  catch_stop_signals();
  auto guard = hal::kobuki::LineGuard::start(-1);
  if (!guard) return guard.error();
  guard_.emplace(std::move(guard).value());
  begin_ns_ = clock_.now();
  if (auto recording = begin_recording(); !recording) return recording;
  auto buses = Buses::open(board_, clock_, options_.record);
  if (!buses) return buses.error();
  buses_ = std::move(buses).value();
  if (hal::has_fault_of(staging_.faults, hal::FaultPart::disk)) {
    bad_disk_.emplace(staging_.faults, [this] { return clock_.now() - begin_ns_; });
    disk_instead_.emplace(*bad_disk_);
  }
  if (place) {
    observable_ = std::move(place->observable);
    meter_.emplace(observable_);
    auto building = hal::RealTimeBuilding::start(std::move(place->world),
                                                 building_options(options_, config_, staging_.faults), clock_);
    if (!building) return building.error();
    building_ = std::move(building).value();
    sim_camera_ = std::make_unique<hal::RealTimeBuilding::Camera>(*building_, 0, rate_hz);
    if (kinect_ != nullptr) kinect_->show(*sim_camera_);
  }
  if (board_.camera_source.starts_with(kStreamSource)) {
    auto place_of_stream = hal::parse_stream_place(board_.camera_source.substr(kStreamSource.size()));
    if (!place_of_stream) return hal::Error{hal::Reason::bad_usage, "camera.source: " + place_of_stream.error().text};
    stream_camera_ = std::make_unique<hal::StreamCamera>(std::move(place_of_stream).value(), config_.camera, clock_,
                                                         clock_.slow_percent());
  }
  if (auto opened = port_.open(); !opened && !options_.await_base) return opened;
  hal::DepthCamera& eye = recording_ != nullptr ? recording_->camera(camera()) : camera();
  nav::RobotParts parts{port_, eye, clock_, [this] { end_camera(); }, &*guard_, nullptr, {}};
  if (recording_ != nullptr) record(parts);
  if (meter_) parts.coverage = [this](const nav::GroundMap& ground) { return meter_->fraction(ground.states()); };
  nav::RobotThreadsConfig threads;
  threads.robot = config_;
  buses_->equip(threads);
  robot_ = std::make_unique<nav::RobotThreads>(threads, parts);
  if (const auto missing = missing_card(robot_->mapper(), options_.mapping)) {
    return hal::Error{hal::Reason::unsupported, *missing};
  }
  if (fleet) {
    auto opened = Fleet::open(std::move(*fleet), robot_->mapper().map(), clock_);
    if (!opened) return opened.error();
    fleet_ = std::move(opened).value();
    robot_->share(fleet_->thread().view(),
                  [this](std::span<const std::uint32_t> slots) { fleet_->thread().note_changed(slots); });
    if (robot_->loops() != nullptr) fleet_->share_submaps(*robot_->loops());
    robot_->join_team(team_link_);
    fleet_->speak_for(team_link_, robot_->status());
  }
  auto control = open_control(options_.staging, options_.mapping.out_dir, robot_->hotline(),
                              [this](std::string_view request) { return answer(request); });
  if (!control) return control.error();
  control_ = std::move(control).value();
  return {};
}

std::optional<std::string> LiveRun::answer(std::string_view request) {
  if (auto said = buses_->answer(request)) return said;
  if (fleet_ != nullptr) return fleet_->answer(request);
  if (!request.starts_with("peers")) return std::nullopt;
  return "{\"error\": \"this robot is alone: it was started without the key of a fleet\"}\n";
}

hal::Result<void> LiveRun::begin_recording() {
  if (options_.record.empty()) return {};
  auto recording = RunRecording::begin(options_.record, board_, config_.camera, !options_.mapping.no_colour);
  if (!recording) return recording.error();
  recording_ = std::move(recording).value();
  return {};
}

void LiveRun::record(nav::RobotParts& parts) {
  parts.recorder = recording_->line();
  hal::FrameRecorder* const frames = recording_->frames();
  if (frames == nullptr) return;
  parts.on_mapped = [frames](const hal::MappedNote& note, const hal::Frame* masked) {
    frames->put_mapped(note, masked);
  };
}

void LiveRun::end_recording(const std::string& hash) {
  if (recording_ == nullptr) return;
  std::vector<std::string> cannot;
  if (robot_->loops() != nullptr) cannot.emplace_back("the whole map was corrected while it grew (--loops)");
  if (robot_->pool_full_frames() > 0) cannot.emplace_back("the map's memory was full, and took what came first");
  recording_->end(hash, std::move(cannot));
}

void LiveRun::run(bool show_progress) {
  show_progress = show_progress && isatty(STDERR_FILENO) != 0;
  const hal::TimeNs start_ns = clock_.now();
  const hal::TimeNs end_ns =
      options_.duration_s > 0.0 ? start_ns + static_cast<hal::TimeNs>(options_.duration_s * 1e9) : INT64_MAX;
  hal::TimeNs next_show_ns = start_ns;
  if (fleet_ != nullptr) fleet_->start();
  if (service_.is_supervised()) buses_->set_on_all_alive([this] { service_.all_alive(); });
  if (service_.alive_period_ns() > 0) buses_->leave_watchdog(service_.alive_period_ns());
  buses_->start();
  robot_->start();
  nav::LiveStatus status;
  while (!is_stop_requested() && clock_.now() < end_ns && !robot_->camera_has_ended()) {
    clock_.sleep_until(std::min(end_ns, clock_.now() + kLiveLook_ns));
    buses_->tick_main();
    take_poses();
    say_words(clock_.now() - start_ns);
    const bool has_status = robot_->status().read(status) != 0;
    if (has_status && kinect_ != nullptr) kinect_->light_up(status);
    service_.look(clock_.now(), way_.size(), status);
    if (has_status && status.state == nav::MissionState::home) break;
    if (show_progress && clock_.now() >= next_show_ns) {
      next_show_ns = clock_.now() + kProgress_ns;
      show(clock_.now() - start_ns, status);
    }
  }
  if (show_progress) fmt::print(stderr, "\n");
  buses_->rest_main();
  robot_->stop();
  service_.stopping();
  buses_->stop();
  if (fleet_ != nullptr) {
    // Who has said Ctrl-C is in a hurry, and another one would end the program without the map.
    fleet_->settle(options_.network.settle_s.value_or(was_interrupted() ? kHurriedSettle_s : kSettle_s),
                   [was = was_interrupted()] { return !was && is_stop_requested(); });
    fleet_->stop();
  }
  if (control_ != nullptr) control_counts_ = control_->counts();
  control_.reset();
  end_ns_ = clock_.now();
  run_s_ = static_cast<double>(end_ns_ - start_ns) / 1e9;
  take_poses();
  note_base();
}

void LiveRun::show(hal::TimeNs since_ns, const nav::LiveStatus& status) const {
  fmt::print(stderr, "\r{:6.0f} s", static_cast<double>(since_ns) / 1e9);
  if (status.coverage >= 0.0) fmt::print(stderr, "  {:5.1f} % seen", 100.0 * status.coverage);
  fmt::print(stderr, "  {:6.1f} m driven  {}", status.path_m, nav::name_of(status.state));
  net::SharingBrief brief;
  if (fleet_ != nullptr && fleet_->thread().brief().read(brief) != 0) fmt::print(stderr, "  {}", brief_text(brief));
  fmt::print(stderr, "     ");
}

void LiveRun::say_words(hal::TimeNs since_ns) {
  for (; next_word_ < staging_.words.size() && staging_.words[next_word_].at_ns <= since_ns; ++next_word_) {
    (void)robot_->hotline().say(staging_.words[next_word_].word);
  }
}

bool LiveRun::was_interrupted() const { return is_stop_requested(); }

std::optional<nav::OutsideView> LiveRun::outside() {
  if (building_ == nullptr) return std::nullopt;
  return building_->with(
      0, [](const hal::SimBuilding& building, const hal::BaseCable&) { return nav::outside_view(building.record(0)); });
}

void LiveRun::write_camera(mapper::JsonWriter& json) const {
  if (stream_camera_ != nullptr) write_stream(json, stream_camera_->counts());
}

double LiveRun::building_late_s() const {
  return building_ == nullptr ? 0.0 : static_cast<double>(building_->latest_step_ns()) / 1e9;
}

hal::Result<void> LiveRun::finish_recording() {
  auto buses = buses_->finish_recording();
  return recording_ == nullptr ? std::move(buses) : recording_->finish();
}

std::vector<nav::ThreadTime> LiveRun::thread_times() const {
  std::vector<nav::ThreadTime> times = robot_->thread_times();
  if (fleet_ != nullptr) times.push_back({"sharing", fleet_->thread().cpu_s()});
  times.push_back({"guard", static_cast<double>(hal::children_cpu_ns()) * 1e-9});
  return times;
}

hal::Result<std::string> LiveRun::find_port() {
  if (board_.base_line == "sim") return building_->path(0);
  if (board_.base_line != "auto") return board_.base_line;
  const auto found = hal::find_usb_serial({});
  if (!found) return found.error();
  return found.value().path;
}

hal::DepthCamera& LiveRun::camera() {
  if (kinect_ != nullptr) return kinect_->camera();
  if (sim_camera_ != nullptr) return *sim_camera_;
  if (stream_camera_ != nullptr) return *stream_camera_;
  return no_camera_;
}

void LiveRun::end_camera() {
  if (kinect_ != nullptr) kinect_->end();
  if (sim_camera_ != nullptr) sim_camera_->stop();
  if (stream_camera_ != nullptr) stream_camera_->stop();
  no_camera_.stop();
}

// Kept in memory until the end: the loop that looks after the threads, the time and Ctrl-C must not wait for a disk.
void LiveRun::take_poses() {
  hal::StampedPose pose;
  while (robot_->next_pose(pose)) way_.push_back(pose);
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
    base_.stands = building_->with(0, [](hal::SimBuilding& building, hal::BaseCable&) {
      return building.kobuki(0).drive() == hal::kobuki::BaseControl{};
    });
  }
}

}  // namespace g3d
