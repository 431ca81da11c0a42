// SPDX-License-Identifier: Apache-2.0
// `g3dmap building`: a simulated building in real time whose robots are driven by other programs. Each robot has two
// ends: the serial line of its base, and its camera's frames as a byte stream. Whoever drives, comes and goes; the
// building goes on.
#include "main_building.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <numbers>
#include <utility>

#include "hal/image/file_bytes.hpp"
#include "hal/linux/control_socket.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/pty_kobuki.hpp"
#include "hal/sim/real_time_building.hpp"
#include "hal/sim/seen_cells.hpp"
#include "hal/sim/socket_cable.hpp"
#include "main_commands.hpp"
#include "main_robot.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"
#include "mapper/version.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kBuildingLook_ns = 50'000'000;
constexpr std::string_view kListen = "listen:";
constexpr std::string_view kTerminal = "pty:";

std::atomic<bool> building_stop{false};

void on_building_signal(int) { building_stop.store(true); }

void catch_building_signals() {
  struct sigaction action {};
  action.sa_handler = on_building_signal;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

hal::Result<hal::PlanarPose> parse_start(std::string_view text, const hal::World& world) {
  std::array<double, 3> numbers{};
  std::string_view rest = text;
  bool is_good = true;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t comma = i + 1 < numbers.size() ? rest.find(',') : rest.size();
    const auto number = comma <= rest.size() ? hal::parse_double(rest.substr(0, comma)) : std::nullopt;
    is_good = is_good && number && std::abs(*number) <= 1e5;
    numbers[i] = number.value_or(0.0);
    rest = comma < rest.size() ? rest.substr(comma + 1) : std::string_view{};
  }
  if (!is_good) return hal::Error{hal::Reason::bad_usage, fmt::format("--start '{}': not X,Y,DEGREES", text)};
  if (!hal::fits(hal::FloorContact(world), numbers[0], numbers[1], {})) {
    return hal::Error{hal::Reason::bad_usage, fmt::format("--start {}: a robot does not fit there", text)};
  }
  return hal::PlanarPose{numbers[0], numbers[1], numbers[2] * std::numbers::pi / 180.0};
}

hal::Result<std::vector<hal::PlanarPose>> starts_of(const BuildingOptions& options, const hal::World& world,
                                                    std::size_t robots) {
  if (options.starts.empty()) return hal::choose_starts(world, robots, options.mapping.seed);
  if (options.starts.size() != robots) {
    return hal::Error{hal::Reason::bad_usage, fmt::format("{} robots, but {} times --start; give it once for each",
                                                          robots, options.starts.size())};
  }
  std::vector<hal::PlanarPose> starts;
  for (const std::string& text : options.starts) {
    const auto start = parse_start(text, world);
    if (!start) return start.error();
    starts.push_back(start.value());
  }
  return starts;
}

hal::Result<hal::StreamLink> open_link(std::string_view text, const char* option) {
  const bool listens = text.starts_with(kListen);
  auto place = hal::parse_stream_place(listens ? text.substr(kListen.size()) : text);
  if (!place) return hal::Error{place.error().reason, fmt::format("{} {}", option, place.error().text)};
  if (listens) return hal::StreamLink::listen(std::move(place).value());
  return hal::StreamLink::dial(std::move(place).value());
}

hal::Result<std::unique_ptr<hal::BaseCable>> open_cable(const std::string& text, const hal::Clock& clock) {
  if (text.starts_with(kTerminal)) {
    auto terminal = hal::PtyKobuki::open(text.substr(kTerminal.size()));
    if (!terminal) return terminal.error();
    return std::unique_ptr<hal::BaseCable>(std::make_unique<hal::PtyKobuki>(std::move(terminal).value()));
  }
  auto link = open_link(text, "--base");
  if (!link) return link.error();
  return std::unique_ptr<hal::BaseCable>(std::make_unique<hal::SocketCable>(std::move(link).value(), clock));
}

/// What is named for robot `i`, or what lies in the folder by default.
hal::Result<std::string> end_of(const std::vector<std::string>& named, std::size_t i, const std::string& folder,
                                const char* option, const std::string& by_default) {
  if (i < named.size()) return named[i];
  if (!folder.empty()) return by_default;
  return hal::Error{hal::Reason::bad_usage,
                    fmt::format("robot {} has no {}; name one, or give --at FOLDER", i + 1, option)};
}

struct RobotEnd {
  hal::PlanarPose start;
  std::unique_ptr<hal::SeenCells> seen;
  std::unique_ptr<hal::RealTimeBuilding::Camera> camera;
  std::unique_ptr<hal::FrameServer> server;
};

class Served {
 public:
  /// Errors: of usage, of files, or of sockets.
  [[nodiscard]] hal::Result<void> begin(const BuildingOptions& options);
  void run(double duration_s);
  [[nodiscard]] std::string truth();
  void say_where(const BuildingOptions& options);

 private:
  std::unique_ptr<hal::SlowClock> clock_;
  hal::Observable observable_;
  std::unique_ptr<hal::RealTimeBuilding> building_;
  std::vector<RobotEnd> robots_;
  std::unique_ptr<hal::ControlSocket> control_;
};

hal::SimBuildingOptions options_of(const BuildingOptions& options, const board::Board& board,
                                   const hal::CameraModel& camera, const Staging& staging,
                                   const std::vector<hal::PlanarPose>& starts) {
  hal::SimBuildingOptions building;
  building.camera = camera;
  building.noise = !options.no_noise;
  building.seed = options.mapping.seed;
  building.faults = staging.faults;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    hal::SimRobotOptions robot;
    robot.T_world_base = starts[i];
    robot.T_base_camera = mount_pose(board);
    robot.base.seed = options.mapping.seed + i;
    hal::add_drift(robot, options.drift, options.mapping.seed + i, drift_like(options.drift_like));
    set_battery(robot.base, options.staging);
    building.robots.push_back(robot);
  }
  return building;
}

hal::Result<void> Served::begin(const BuildingOptions& options) {
  const auto board = effective_board(options.mapping);
  if (!board) return board.error();
  const auto camera = choose_camera(board.value(), options.camera);
  if (!camera) return camera.error();
  const auto staging = read_staging(options.staging);
  if (!staging) return staging.error();
  if (hal::has_fault_of(staging.value().faults, hal::FaultPart::disk)) {
    return hal::Error{hal::Reason::bad_usage, "--fail: a disk is the robot's own, not the building's"};
  }
  const auto crop = choose_rectangle("--crop", options.crop);
  if (!crop) return crop.error();
  auto world = hal::load_world(options.world, crop.value());
  if (!world) return world.error();
  const std::size_t count =
      std::max({static_cast<std::size_t>(options.robots), options.bases.size(), options.frames.size()});
  const auto starts = starts_of(options, world.value(), count);
  if (!starts) return starts.error();
  auto observable = hal::find_observable(world.value(), starts.value());
  if (!observable) return observable.error();
  observable_ = std::move(observable).value();

  clock_ = std::make_unique<hal::SlowClock>(static_cast<std::uint32_t>(std::lround(100.0 * options.slow)));
  std::vector<std::unique_ptr<hal::BaseCable>> cables;
  std::vector<hal::StreamLink> links;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string stem = fmt::format("{}/robot{}", options.at, i + 1);
    const auto base = end_of(options.bases, i, options.at, "--base", "pty:" + stem + ".base");
    const auto frames = end_of(options.frames, i, options.at, "--frames", "listen:" + stem + ".frames");
    if (!base) return base.error();
    if (!frames) return frames.error();
    auto cable = open_cable(base.value(), *clock_);
    if (!cable) return cable.error();
    cables.push_back(std::move(cable).value());
    auto link = open_link(frames.value(), "--frames");
    if (!link) return link.error();
    links.push_back(std::move(link).value());
  }
  building_ = hal::RealTimeBuilding::start(
      std::move(world).value(),
      options_of(options, board.value(), camera.value().model, staging.value(), starts.value()), *clock_,
      std::move(cables));
  for (std::size_t i = 0; i < count; ++i) {
    RobotEnd robot;
    robot.start = starts.value()[i];
    robot.seen = std::make_unique<hal::SeenCells>(observable_);
    robot.camera = std::make_unique<hal::RealTimeBuilding::Camera>(*building_, i, camera.value().rate_hz);
    robot.server = std::make_unique<hal::FrameServer>(
        *robot.camera, [eye = robot.camera.get()] { eye->stop(); }, std::move(links[i]), *clock_,
        clock_->slow_percent(),
        [eye = robot.camera.get(), seen = robot.seen.get()](const hal::Frame& frame) {
          seen->look(frame, eye->model(), eye->glance().T_world_camera);
        });
    robots_.push_back(std::move(robot));
  }
  if (options.at.empty() && options.staging.control.empty()) return {};
  auto control =
      hal::ControlSocket::open(options.staging.control.empty() ? options.at + "/control" : options.staging.control,
                               [this](std::string_view request) -> std::string {
                                 if (request.ends_with('\n')) request.remove_suffix(1);
                                 if (request == "stop") building_stop.store(true);
                                 if (request == "stop" || request == "status") return truth();
                                 return "{\"error\": \"a building knows status and stop\"}\n";
                               });
  if (!control) return control.error();
  control_ = std::move(control).value();
  return {};
}

void Served::run(double duration_s) {
  const hal::TimeNs end_ns =
      duration_s > 0.0 ? building_->begin_ns() + static_cast<hal::TimeNs>(duration_s * 1e9) : INT64_MAX;
  while (!building_stop.load() && clock_->now() < end_ns) {
    clock_->sleep_until(std::min(end_ns, clock_->now() + kBuildingLook_ns * 100 / clock_->slow_percent()));
  }
  control_.reset();
}

std::string Served::truth() {
  const auto rounded = [](double x) { return std::round(x * 1e4) / 1e4; };
  mapper::JsonWriter json;
  json.begin_object().member("time_s", rounded(static_cast<double>(clock_->now() - building_->begin_ns()) * 1e-9));
  json.member("slow", clock_->slow_percent() / 100.0);
  json.member("latest_step_ms", rounded(static_cast<double>(building_->latest_step_ns()) * 1e-6));
  std::vector<const hal::SeenCells*> eyes;
  for (const RobotEnd& robot : robots_) eyes.push_back(robot.seen.get());
  json.member("coverage", rounded(hal::SeenCells::fraction(eyes)));
  json.key("robots").begin_array();
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    json.begin_object().member("number", i + 1).member("coverage", rounded(robots_[i].seen->fraction()));
    building_->with(i, [&](hal::SimBuilding& building, const hal::BaseCable& cable) {
      write_truth_of(json, building, cable, i, robots_[i].start);
    });
    write_served(json, robots_[i].server->counts());
    json.end_object();
  }
  json.end_array().member("version", mapper::version()).end_object();
  return json.take();
}

void Served::say_where(const BuildingOptions& options) {
  fmt::print(stderr, "g3dmap: building {}, {} robots", options.world, robots_.size());
  if (options.slow > 1.0) fmt::print(stderr, ", {:g} times slow", options.slow);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const hal::PlanarPose& start = robots_[i].start;
    fmt::print(stderr, "\n  robot {} at {:.2f},{:.2f},{:.0f}  base {}", i + 1, start.x_m, start.y_m,
               start.heading_rad * 180.0 / std::numbers::pi, building_->path(i));
  }
  fmt::print(stderr, "\n");
}

}  // namespace

int run_building(const BuildingOptions& options) {
  catch_building_signals();
  if (!options.at.empty()) {
    std::error_code code;
    std::filesystem::create_directories(options.at, code);
    if (code)
      return fail(fmt::format("{}: cannot create this folder: {}; choose another --at", options.at, code.message()));
  }
  Served served;
  if (const auto begun = served.begin(options); !begun) return fail_as(begun.error());
  if (!options.mapping.quiet) served.say_where(options);
  served.run(options.duration_s);
  const std::string truth = served.truth();
  if (options.mapping.json) fmt::print("{}", truth);
  if (options.at.empty()) return kExitDone;
  if (const auto written = hal::write_file_atomic(options.at + "/truth.json", truth); !written) {
    return fail(written.error().text);
  }
  return kExitDone;
}

}  // namespace g3d
