// SPDX-License-Identifier: Apache-2.0
#include <errno.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "hal/boot/network_card.hpp"
#include "hal/boot/wall_clock.hpp"
#include "main_init.hpp"

namespace g3d::init {
namespace {

using hal::boot::RobotHealth;

constexpr hal::TimeNs kSupervisorSecond_ns = 1'000'000'000;
constexpr hal::TimeNs kSupervisorLook_ns = 100'000'000;  // at the latest; a watchdog is fed so often
constexpr hal::TimeNs kSaveTime_ns = 60 * kSupervisorSecond_ns;
constexpr hal::TimeNs kReceiverWait_ns = 5 * kSupervisorSecond_ns;
constexpr hal::TimeNs kRobotEnd_ns = 30 * kSupervisorSecond_ns;  // it saves its map
constexpr const char* kNotifyPath = "/run/notify";
constexpr const char* kUpdateKey = "/system/update.pub";
constexpr const char* kUpdatePort = "7178";
// For reboot: what Ctrl-Alt-Del, or another process, asks for. SIGTERM and SIGINT start anew, SIGUSR2 switches off.
constexpr std::array<int, 4> kSignals = {SIGCHLD, SIGTERM, SIGINT, SIGUSR2};

RobotHealth::Limits limits_of(const hal::boot::InitConfig& config) {
  RobotHealth::Limits limits;
  limits.silent_ns = config.silent_ms * 1'000'000LL;
  limits.start_ns = config.start_s * kSupervisorSecond_ns;
  return limits;
}

}  // namespace

Supervisor::Supervisor(Machine& machine, const hal::Clock& clock)
    : machine_(machine),
      clock_(clock),
      health_(limits_of(machine.config)),
      trial_(machine.config.prove_s * kSupervisorSecond_ns),
      restarts_(machine.config.when_done) {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int one : kSignals) ::sigaddset(&signals, one);
  ::sigprocmask(SIG_BLOCK, &signals, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  signals_fd_ = ::signalfd(-1, &signals, SFD_NONBLOCK | SFD_CLOEXEC);
  (void)::fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  auto notices = hal::boot::NotifySocket::open(kNotifyPath);
  if (notices) {
    notices_ = std::move(notices).value();
  } else {
    machine_.speaker.say(notices.error().text);
  }
  save_time_ns_ = clock_.now() + kSaveTime_ns;
}

Supervisor::~Supervisor() {
  if (signals_fd_ >= 0) ::close(signals_fd_);
}

Supervisor::End Supervisor::run() {
  start_network();
  while (!end_) {
    if (!robot_.is_running() && clock_.now() >= start_again_ns_) start_robot();
    if (!receiver_.is_running() && clock_.now() >= start_receiver_ns_) start_receiver();
    wait_for_something();
    on_signals();
    robot_.read_lines([this](std::string_view line) { machine_.speaker.pass_on("robot", line); });
    receiver_.read_lines([this](std::string_view line) { machine_.speaker.pass_on("update", line); });
    aside_.read_lines([this](std::string_view line) { machine_.speaker.pass_on("aside", line); });
    on_notices();
    on_console();
    look_after_health();
    look_after_network();
    look_after_time();
  }
  stop_robot();
  look_after_time();
  if (const auto saved = hal::boot::save_time(kClockFile, ::time(nullptr)); !saved && machine_.has_data) {
    machine_.speaker.say(saved.error().text);
  }
  return *end_;
}

void Supervisor::start_robot() {
  hal::boot::ChildProcess::Command command;
  command.program = machine_.program;
  command.arguments = machine_.config.arguments;
  // The GPU helper finds L4T's libraries beside the program, and the driver may keep what it has compiled.
  command.environment = {"PATH=/system",
                         "HOME=/data",
                         "LD_LIBRARY_PATH=/system/gpu/lib",
                         "CUDA_CACHE_PATH=/data/cuda_cache",
                         fmt::format("NOTIFY_SOCKET={}", kNotifyPath),
                         fmt::format("WATCHDOG_USEC={}", machine_.config.silent_ms * 1000LL)};
  robot_started_ns_ = clock_.now();
  start_again_ns_ = INT64_MAX;
  if (const auto started = robot_.start(command); !started) {
    machine_.speaker.say(started.error().text);
    on_robot_end({127, 0});
    return;
  }
  health_.on_start(robot_started_ns_);
  ++starts_;
  machine_.speaker.say(
      fmt::format("the robot is started{}", starts_ > 1 ? fmt::format(", for the {}. time", starts_) : ""));
}

void Supervisor::start_receiver() {
  start_receiver_ns_ = INT64_MAX;
  const std::string key = ::access("/data/update.pub", R_OK) == 0 ? "/data/update.pub" : kUpdateKey;
  if (!machine_.has_data || machine_.slot_a.empty() || machine_.slot_b.empty() || ::access(key.c_str(), R_OK) != 0)
    return;
  hal::boot::ChildProcess::Command command;
  command.program = "/init";
  command.arguments = {"update",
                       "--listen",
                       kUpdatePort,
                       "--trust",
                       key,
                       "--state",
                       kSlotBook,
                       "--slot-a",
                       machine_.slot_a,
                       "--slot-b",
                       machine_.slot_b,
                       "--running",
                       machine_.slot ? to_string(*machine_.slot) : "none"};
  if (const auto started = receiver_.start(command); !started) machine_.speaker.say(started.error().text);
}

void Supervisor::start_network() {
  look_for_card_ns_ = INT64_MAX;
  const hal::boot::InitConfig& config = machine_.config;
  if (config.interface == "none") return;
  std::string card = config.interface;
  if (card == "auto") {
    const std::vector<std::string> cards = hal::boot::ethernet_cards();
    card = cards.empty() ? "" : cards.front();
  }
  if (card.empty() || hal::boot::index_of(card) == 0) {
    look_for_card_ns_ = clock_.now() + kSupervisorSecond_ns;  // one at USB may come late
    return;
  }
  auto keeper = hal::boot::NetworkKeeper::start({config.name, card, config.address, config.gateway}, clock_.now());
  if (!keeper) {
    machine_.speaker.say(keeper.error().text);
    look_for_card_ns_ = clock_.now() + kSupervisorSecond_ns;
    return;
  }
  network_ = std::move(keeper).value();
  look_after_network();
}

void Supervisor::wait_for_something() {
  std::vector<pollfd> polled;
  const auto add = [&](int fd) {
    if (fd >= 0) polled.push_back({fd, POLLIN, 0});
  };
  add(signals_fd_);
  add(robot_.output_fd());
  add(receiver_.output_fd());
  add(aside_.output_fd());
  if (!console_is_gone_) add(STDIN_FILENO);
  if (notices_) add(notices_->fd());
  if (network_) {
    for (const int fd : network_->fds()) add(fd);
  }
  (void)::poll(polled.data(), polled.size(), static_cast<int>(kSupervisorLook_ns / hal::kMillisecond_ns));
}

void Supervisor::on_signals() {
  signalfd_siginfo info{};
  while (::read(signals_fd_, &info, sizeof info) == static_cast<ssize_t>(sizeof info)) {
    const int signal = static_cast<int>(info.ssi_signo);
    if (signal == SIGTERM || signal == SIGINT) end_with(End::reboot);
    if (signal == SIGUSR2) end_with(End::power_off);
  }
  reap();
}

// Orphans too: whoever loses its parent becomes a child of the first process.
void Supervisor::reap() {
  int status = 0;
  for (pid_t child = 0; (child = ::waitpid(-1, &status, WNOHANG | __WALL)) > 0;) {
    const auto end = hal::boot::end_of(status);
    if (!end) continue;
    if (child == robot_.pid()) {
      robot_.on_end([this](std::string_view line) { machine_.speaker.pass_on("robot", line); });
      on_robot_end(*end);
    } else if (child == aside_.pid()) {
      aside_.on_end([this](std::string_view line) { machine_.speaker.pass_on("aside", line); });
      machine_.speaker.say("what ran beside the robot has ended: " + hal::boot::to_text(*end));
    } else if (child == receiver_.pid()) {
      receiver_.on_end([this](std::string_view line) { machine_.speaker.pass_on("update", line); });
      start_receiver_ns_ = clock_.now() + kReceiverWait_ns;
      if (end->is_good()) {
        machine_.speaker.say("a new system is installed");
        end_with(End::reboot);
      } else if (end->exit_code == 2) {
        start_receiver_ns_ = INT64_MAX;
      }
    }
  }
}

void Supervisor::on_robot_end(const hal::boot::ProcessEnd& end) {
  health_.on_end();
  const hal::TimeNs now_ns = clock_.now();
  (void)trial_.note(now_ns, false);
  std::string text =
      fmt::format("the robot has ended after {:.1f} s: {}",
                  static_cast<double>(now_ns - robot_started_ns_) / static_cast<double>(kSupervisorSecond_ns),
                  hal::boot::to_text(end));
  if (end_) return machine_.speaker.say(text);
  const auto next = restarts_.on_end(end, now_ns - robot_started_ns_, machine_.is_on_trial);
  switch (next.step) {
    case hal::boot::NextStep::start_again:
      start_again_ns_ = now_ns + next.wait_ns;
      text += fmt::format("; again in {:.1f} s",
                          static_cast<double>(next.wait_ns) / static_cast<double>(kSupervisorSecond_ns));
      break;
    case hal::boot::NextStep::stay:
      text += "; its work is done";
      break;
    case hal::boot::NextStep::power_off:
      end_with(End::power_off);
      break;
    case hal::boot::NextStep::reboot:
      text += "; this system is on trial and does not run";
      end_with(End::reboot);
      break;
  }
  machine_.speaker.say(text);
}

void Supervisor::on_notices() {
  while (notices_) {
    const auto notice = notices_->receive();
    if (!notice) return;
    if (!notice->status.empty() && notice->status != robot_status_) {
      robot_status_ = notice->status;
      machine_.speaker.pass_on("robot", robot_status_);
    }
    if (notice->is_ready) machine_.speaker.say("the robot maps");
    health_.on_notice(*notice, clock_.now());
  }
}

void Supervisor::look_after_health() {
  const hal::TimeNs now_ns = clock_.now();
  const bool may_feed = health_.may_feed(now_ns);
  if (may_feed) machine_.watchdog.feed();
  if (may_feed != was_fed_) {
    machine_.speaker.say(fmt::format("the robot is {}: the watchdog is {}", to_string(health_.state(now_ns)),
                                     may_feed ? "fed again" : "not fed any more"));
    was_fed_ = may_feed;
    // Without a watchdog this process has to do what it can.
    if (!may_feed && !machine_.watchdog.is_open() && robot_.is_running()) (void)::kill(robot_.pid(), SIGKILL);
  }
  const bool is_running = health_.state(now_ns) == RobotHealth::State::running;
  if (!trial_.note(now_ns, is_running) || is_told_good_) return;
  is_told_good_ = true;
  if (!machine_.slot || !machine_.has_data) return;
  hal::SlotStore store(kSlotBook);
  const auto kept = store.change(
      [&](hal::SlotBook book) { return hal::Result<hal::SlotBook>(hal::started_well(book, *machine_.slot)); });
  if (!kept) return machine_.speaker.say(kept.error().text);
  if (machine_.is_on_trial) machine_.speaker.say(fmt::format("system {} has proved itself", to_string(*machine_.slot)));
  machine_.is_on_trial = false;
}

void Supervisor::look_after_network() {
  const hal::TimeNs now_ns = clock_.now();
  if (!network_) {
    if (now_ns >= look_for_card_ns_) start_network();
    return;
  }
  network_->on_time(now_ns);
  for (const std::string& trouble : network_->take_troubles()) machine_.speaker.say(trouble);
  if (network_->address() == address_) return;
  address_ = network_->address();
  machine_.speaker.say(
      address_ ? fmt::format("network: {} is {}.local", hal::boot::ipv4_text(*address_), machine_.config.name)
               : "network: the address is taken, another one is looked for");
}

void Supervisor::look_after_time() {
  if (clock_.now() < save_time_ns_) return;
  save_time_ns_ = clock_.now() + kSaveTime_ns;
  (void)hal::boot::save_time(kClockFile, ::time(nullptr));
}

void Supervisor::end_with(End end) {
  if (!end_) end_ = end;
}

void Supervisor::stop_robot() {
  if (receiver_.is_running()) (void)::kill(receiver_.pid(), SIGTERM);
  if (!robot_.is_running()) return;
  machine_.speaker.say("the robot is told to end");
  (void)::kill(robot_.pid(), SIGTERM);
  const hal::TimeNs until_ns = clock_.now() + kRobotEnd_ns;
  while (robot_.is_running() && clock_.now() < until_ns) {
    machine_.watchdog.feed();
    wait_for_something();
    on_signals();
    robot_.read_lines([this](std::string_view line) { machine_.speaker.pass_on("robot", line); });
    on_notices();
  }
}

}  // namespace g3d::init
