// SPDX-License-Identifier: Apache-2.0
// From an emergency stop to zero speed on the wire, measured at the base's end of a pseudo-terminal: from just before
// the edge, or the frame on the bus, to the last byte of zero speed. Codec, switch logic, base thread and port are the
// real ones; the GPIO line and the bus are simulated where the kernel has none.
//   estop_bench [--trials N] [--can INTERFACE]
// With --can the frames go through the kernel's CAN (a vcan will do): the node that stops us is at another socket of
// the same interface. What holds the stop-watch runs at a priority that nobody disturbs.
#include <fmt/format.h>
#include <linux/can.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hal/can/can_safety.hpp"
#include "hal/gpio/gpio_safety.hpp"
#include "hal/kobuki/base_thread.hpp"
#include "hal/linux/can_socket.hpp"
#include "hal/linux/serial_port.hpp"
#include "tests/support/command_tap.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/scripted_base.hpp"
#include "tests/support/scripted_gpio.hpp"

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kMs = kMillisecond_ns;
constexpr TimeNs kPatience_ns = 20'000 * kMs;
constexpr std::uint8_t kNode = 17;
constexpr TimeNs kHeartbeat_ns = 200 * kMs;
constexpr int kHardwarePriority = 60;

bool set_priority(int priority) {
  const sched_param parameters{priority};
  return ::sched_setscheduler(0, priority > 0 ? SCHED_FIFO : SCHED_OTHER, &parameters) == 0;
}

/// The two ends of a bus.
std::array<int, 2> open_bus(const std::string& interface) {
  std::array<int, 2> ends{-1, -1};
  if (interface.empty()) {
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) std::abort();
    return ends;
  }
  for (int& end : ends) {
    const auto fd = open_can_socket(interface);
    if (!fd) {
      fmt::print(stderr, "{}\n", fd.error().text);
      std::exit(1);
    }
    end = fd.value();
  }
  return ends;
}

/// The node at the other end: a heartbeat each 50 ms, and what it is told to say.
class StopNode {
 public:
  explicit StopNode(int fd) : socket_(fd), thread_([this] { run(); }) {}
  ~StopNode() {
    ending_.store(true);
    thread_.join();
  }
  void set_silent(bool silent) { silent_.store(silent); }
  [[nodiscard]] TimeNs last_heartbeat_ns() const { return last_heartbeat_ns_.load(); }
  /// From the caller's thread, between two heartbeats of the other: each frame is one system call.
  TimeNs say(const can::Emergency& emergency) {
    const can::CanFrame frame = encode(emergency);
    can_frame raw{};
    raw.can_id = frame.id;
    raw.can_dlc = frame.size;
    std::copy_n(frame.data.begin(), frame.size, raw.data);
    const TimeNs now_ns = RealClock().now();
    if (::send(fd_of_caller, &raw, sizeof raw, 0) != sizeof raw) return 0;
    return now_ns;
  }
  int fd_of_caller = -1;

 private:
  void run() {
    RealClock clock;
    while (!ending_.load()) {
      can::CanFrame heard;
      while (socket_.read(heard)) {
      }
      if (!silent_.load()) {
        last_heartbeat_ns_.store(clock.now());
        (void)socket_.write(encode(can::Heartbeat{kNode, can::NmtState::operational}));
      }
      clock.sleep_until(clock.now() + 50 * kMs);
    }
  }
  CanSocket socket_;
  std::atomic<bool> silent_{false}, ending_{false};
  std::atomic<TimeNs> last_heartbeat_ns_{0};
  std::thread thread_;
};

struct Row {
  const char* name;
  double limit_ms;
  std::vector<TimeNs> values;
};

bool report(Row& row) {
  std::sort(row.values.begin(), row.values.end());
  const auto at_ms = [&](double part) {
    return static_cast<double>(
               row.values[static_cast<std::size_t>(part * static_cast<double>(row.values.size() - 1))]) *
           1e-6;
  };
  const bool good = !row.values.empty() && row.values.front() >= 0 && at_ms(0.99) <= row.limit_ms;
  if (row.values.empty()) return false;
  fmt::print("{:<40}{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.0f}  {}\n", row.name, row.values.size(), at_ms(0.5),
             at_ms(0.99), at_ms(1.0), row.limit_ms, good ? "kept" : "BROKEN");
  return good;
}

}  // namespace

int main(int argc, char** argv) {
  int trials = 1'000;
  std::string interface;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--trials") == 0) trials = std::max(1, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--can") == 0) interface = argv[i + 1];
  }
  const test::PtyPair pty;
  RealClock clock;
  SerialPort port({[&]() -> Result<std::string> { return pty.path(); }, {}, 100 * kMs}, clock);
  if (!port.open().ok()) return 1;

  const std::array<int, 2> bus = open_bus(interface);
  CanSocket socket(bus[0]);
  can::CanSafetyOptions can_options;
  can_options.estop = {kNode, kHeartbeat_ns};
  can::CanSafety can_safety(socket, can_options);
  test::ScriptedGpio lines;
  GpioSafetyOptions gpio_options;
  gpio_options.estop.settle_ns = 10 * kMs;
  gpio_options.names = {"estop", ""};
  GpioSafety gpio_safety(lines, gpio_options);

  BaseThreadOptions options;
  options.safety_devices = {&can_safety, &gpio_safety};
  BaseThread base(port, clock, options);
  base.start();
  std::atomic<bool> ending{false};
  std::thread others([&] {
    while (!ending.load()) {
      base.set_camera_alive(clock.now());
      base.set_command({0.3, 0.2}, clock.now());
      clock.sleep_until(clock.now() + 10 * kMs);
    }
  });
  std::array<Row, 3> rows{{{"GPIO edge -> zero", 10.0, {}},
                           {"EMCY frame -> zero", 10.0, {}},
                           {"last heartbeat -> zero (timeout 200 ms)", 210.0, {}}}};
  {
    if (!set_priority(kHardwarePriority)) fmt::print(stderr, "no realtime priority: figures include the load\n");
    test::ScriptedBase device(pty.fd());
    StopNode node(bus[1]);
    node.fd_of_caller = bus[1];
    test::CommandTap tap(pty.fd());
    std::uint64_t random = 88172645463325252ULL;
    // At all phases of the 2 ms look and of the 20 ms command.
    const auto get_going = [&] {
      base.resume();
      tap.drain();
      if (tap.wait_for_motion(kPatience_ns) == 0) return false;
      clock.sleep_until(clock.now() + 20 * kMs);
      tap.drain();
      if (tap.wait_for_motion(kPatience_ns) == 0) return false;
      random ^= random << 13, random ^= random >> 7, random ^= random << 17;
      clock.sleep_until(clock.now() + static_cast<TimeNs>(random % 20'000'000));
      return true;
    };
    const auto note = [&](Row& row, TimeNs cause_ns) {
      const TimeNs zero_ns = tap.wait_for_zero(kPatience_ns);
      row.values.push_back(zero_ns == 0 || cause_ns == 0 ? -1 : zero_ns - cause_ns);
    };
    const auto let_go = [&](const auto& release) {
      release();
      clock.sleep_until(clock.now() + 20 * kMs);
    };
    for (int i = 0; i < trials; ++i) {
      if (get_going()) {
        const TimeNs edge_ns = clock.now();
        lines.set(false, edge_ns);
        note(rows[0], edge_ns);
        let_go([&] { lines.set(true, clock.now()); });
      }
      if (get_going()) {
        note(rows[1], node.say({kNode, 0xFF01, 1, {}}));
        let_go([&] { (void)node.say({kNode, 0, 0, {}}); });
      }
      if (i % 10 == 0 && get_going()) {  // each takes a fifth of a second
        node.set_silent(true);
        const TimeNs zero_ns = tap.wait_for_zero(kPatience_ns);
        rows[2].values.push_back(zero_ns == 0 ? -1 : zero_ns - node.last_heartbeat_ns());
        let_go([&] { node.set_silent(false); });
        clock.sleep_until(clock.now() + 100 * kMs);
      }
    }
    (void)set_priority(0);
  }
  ending.store(true);
  others.join();
  base.stop();
  fmt::print("{} bus, {} trials\n{:<40}{:>8}{:>10}{:>10}{:>10}{:>10}\n", interface.empty() ? "simulated" : interface,
             trials, "ms", "trials", "p50", "p99", "max", "limit p99");
  bool good = true;
  for (Row& row : rows) good &= report(row);
  return good ? 0 : 1;
}
