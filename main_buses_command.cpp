// SPDX-License-Identifier: Apache-2.0
// `g3dmap buses`: for whoever wires a robot up. Says what its stop devices say, live or out of recordings; and plays an
// emergency-stop node on a CAN bus that has none yet, to which one speaks through the standard input.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/can_link.hpp"
#include "hal/replay/can_log.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/replay/gpio_log.hpp"
#include "main_buses.hpp"
#include "main_commands.hpp"
#include "main_say.hpp"
#include "main_setup.hpp"

namespace g3d {
namespace {

constexpr hal::TimeNs kBusLook_ns = 2 * hal::kMillisecond_ns;  // as the base's thread does

std::atomic<bool> is_over{false};

void end_on_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { is_over.store(true); };
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
}

const char* name_of(hal::StopWord word) {
  switch (word) {
    case hal::StopWord::go:
      return "go";
    case hal::StopWord::not_yet:
      return "not_yet";
    case hal::StopWord::stop:
      return "stop";
  }
  return "unknown";
}

/// Says each change of a device's word.
struct Watched {
  const char* name;
  hal::SafetyDevice& device;
  std::optional<hal::StopWord> last;

  void look(hal::TimeNs now_ns, hal::TimeNs begin_ns) {
    const hal::StopWord word = device.look(now_ns);
    hal::SafetyNews robot;
    robot.conditions.set(hal::Condition::e_stop, word != hal::StopWord::go);
    device.show(robot, now_ns);
    if (last == word) return;
    last = word;
    fmt::print("{:.3f} {} {}\n", static_cast<double>(now_ns - begin_ns) * 1e-9, name, name_of(word));
    std::fflush(stdout);
  }
};

int replay_logs(const board::Board& board, const std::string& folder) {
  const auto can_log = hal::read_can_log(folder + "/can.log");
  const auto gpio_log = hal::read_gpio_log(folder + "/gpio.log");
  for (const hal::Error* error : {can_log ? nullptr : &can_log.error(), gpio_log ? nullptr : &gpio_log.error()}) {
    if (error != nullptr && error->reason != hal::Reason::not_found) return fail(error->text);
  }
  if (!can_log && !gpio_log) return fail(folder + ": neither can.log nor gpio.log is there");
  hal::DataClock clock;
  const hal::CanLog frames = can_log ? can_log.value() : hal::CanLog{};
  const hal::GpioLog edges = gpio_log ? gpio_log.value() : hal::GpioLog{};
  hal::ReplayedCan port(frames, clock);
  hal::GpioSafetyOptions switch_options = gpio_options(board);
  if (switch_options.estop.lines == 1) switch_options.names[1].clear();
  hal::ReplayedGpio lines(edges, clock, switch_options.names);
  hal::can::CanSafety can(port, can_options(board));
  hal::GpioSafety gpio(lines, switch_options);
  std::vector<Watched> watched;
  hal::TimeNs begin_ns = INT64_MAX, end_ns = 0;
  if (!frames.frames.empty()) {
    watched.push_back({"can", can, {}});
    begin_ns = frames.frames.front().t_ns;
    end_ns = frames.frames.back().t_ns;
  }
  if (!edges.records.empty() && switch_options.has_estop) {
    watched.push_back({"gpio", gpio, {}});
    begin_ns = std::min(begin_ns, edges.records.front().t_ns);
    end_ns = std::max(end_ns, edges.records.back().t_ns);
  }
  if (watched.empty()) return fail(folder + ": nothing was recorded there that the board's stop devices know");
  for (hal::TimeNs t_ns = begin_ns; t_ns <= end_ns + kBusLook_ns; t_ns += kBusLook_ns) {
    clock.advance_to(t_ns);
    for (Watched& one : watched) one.look(t_ns, begin_ns);
  }
  fmt::print("{} frames, {} edges\n", frames.frames.size(), edges.records.size());
  return kExitDone;
}

int watch_devices(const board::Board& board, const BusesOptions& options) {
  hal::RealClock clock;
  auto opened = Buses::open(board, clock, options.record_dir);
  if (!opened) return fail_as(opened.error());
  Buses& buses = *opened.value();
  nav::RobotThreadsConfig config;
  buses.equip(config);
  if (config.base.safety_devices.empty()) {
    return fail("this board has neither a CAN bus nor GPIO lines: see [can] and [gpio] in its file");
  }
  std::vector<Watched> watched;
  // The last one only tells other threads.
  for (std::size_t i = 0; i + 1 < config.base.safety_devices.size(); ++i) {
    const bool is_can = i == 0 && board.can_interface != "none";
    watched.push_back({is_can ? "can" : "gpio", *config.base.safety_devices[i], {}});
  }
  buses.start();
  const hal::TimeNs begin_ns = clock.now();
  const hal::TimeNs end_ns = options.for_s > 0.0 ? begin_ns + static_cast<hal::TimeNs>(options.for_s * 1e9) : INT64_MAX;
  while (!is_over.load() && clock.now() < end_ns) {
    for (Watched& one : watched) one.look(clock.now(), begin_ns);
    config.base.safety_devices.back()->show({}, clock.now());
    clock.sleep_until(clock.now() + kBusLook_ns);
  }
  for (hal::SafetyDevice* device : config.base.safety_devices) device->say_farewell(clock.now());
  buses.stop();
  if (options.json) {
    mapper::JsonWriter json;
    json.begin_object();
    buses.write(json);
    json.end_object();
    fmt::print("{}", json.take());
  }
  const auto finished = buses.finish_recording();
  return finished ? kExitDone : fail(finished.error().text);
}

/// A node that does as a person says: press, release, silence, speak, wait (until a master starts it), quit.
class PlayedNode {
 public:
  PlayedNode(hal::CanSocket& socket, std::uint8_t node, bool waits) : socket_(socket), node_(node), waits_(waits) {
    (void)socket_.write(encode(hal::can::Heartbeat{node_, hal::can::NmtState::boot_up}));
  }
  void step(hal::TimeNs now_ns) {
    hal::can::CanFrame frame;
    while (socket_.read(frame)) {
      const auto message = hal::can::decode(frame);
      const auto* order = std::get_if<hal::can::NmtOrder>(&message);
      if (order == nullptr || (order->node != 0 && order->node != node_)) continue;
      waits_ = order->command != hal::can::NmtCommand::start;
    }
    if (is_silent_ || now_ns < next_ns_) return;
    next_ns_ = now_ns + 100 * hal::kMillisecond_ns;
    using hal::can::NmtState;
    (void)socket_.write(encode(hal::can::Heartbeat{node_, waits_ ? NmtState::pre_operational : NmtState::operational}));
  }
  /// False: quit. What is no word is ignored.
  [[nodiscard]] bool obey(std::string_view word) {
    constexpr std::uint16_t kDeviceSpecific = 0xFF01;
    constexpr std::uint8_t kGenericError = 0x01;
    if (word == "press") (void)socket_.write(encode(hal::can::Emergency{node_, kDeviceSpecific, kGenericError, {}}));
    if (word == "release") (void)socket_.write(encode(hal::can::Emergency{node_, 0, 0, {}}));
    if (word == "silence") is_silent_ = true;
    if (word == "speak") is_silent_ = false;
    if (word == "wait") waits_ = true;
    return word != "quit";
  }

 private:
  hal::CanSocket& socket_;
  const std::uint8_t node_;
  bool waits_, is_silent_ = false;
  hal::TimeNs next_ns_ = 0;
};

int play_node(const BusesOptions& options) {
  const std::size_t colon = options.play_node.rfind(':');
  const auto node = colon == std::string::npos ? std::nullopt : hal::parse_int(options.play_node.substr(colon + 1));
  if (!node || *node < 1 || *node > hal::can::kMaxNode) {
    return bad_usage(fmt::format("--play-node {}: not INTERFACE:NODE, such as can0:17", options.play_node));
  }
  auto fd = hal::open_can_socket(options.play_node.substr(0, colon));
  if (!fd) return fail_as(fd.error());
  hal::CanSocket socket(fd.value());
  hal::RealClock clock;
  PlayedNode played(socket, static_cast<std::uint8_t>(*node), options.waits);
  (void)::fcntl(STDIN_FILENO, F_SETFL, ::fcntl(STDIN_FILENO, F_GETFL) | O_NONBLOCK);
  std::string pending;
  bool goes_on = true, has_input = true;
  while (goes_on && !is_over.load()) {
    played.step(clock.now());
    std::array<char, 256> bytes{};
    const ssize_t count = has_input ? ::read(STDIN_FILENO, bytes.data(), bytes.size()) : -1;
    if (count > 0) pending.append(bytes.data(), static_cast<std::size_t>(count));
    has_input = has_input && count != 0;  // at its end the node goes on as it is
    for (std::size_t end = pending.find('\n'); end != std::string::npos && goes_on; end = pending.find('\n')) {
      goes_on = played.obey(std::string_view(pending).substr(0, end));
      fmt::print("{}\n", pending.substr(0, end));
      std::fflush(stdout);
      pending.erase(0, end + 1);
    }
    if (pending.size() > bytes.size()) pending.clear();
    clock.sleep_until(clock.now() + hal::kMillisecond_ns);
  }
  return kExitDone;
}

}  // namespace

int run_buses(const BusesOptions& options) {
  end_on_signals();
  if (!options.make_vcan.empty()) {
    const auto made = hal::make_virtual_can(options.make_vcan);
    if (!made) return fail_as(made.error());
    if (options.play_node.empty() && options.board_path.empty()) return kExitDone;
  }
  if (!options.play_node.empty()) return play_node(options);
  MappingOptions mapping;
  mapping.board_path = options.board_path;
  const auto board = effective_board(mapping);
  if (!board) return fail(board.error().text);
  return options.log_dir.empty() ? watch_devices(board.value(), options) : replay_logs(board.value(), options.log_dir);
}

}  // namespace g3d
