// SPDX-License-Identifier: Apache-2.0
// How long it takes to stop, measured at the base's end of a pseudo-terminal by another process's clock readings: from
// the first byte of the cause to the last byte of zero speed. Driver, thread, port and guard are the real ones.
//   stop_latency_bench [--trials N] [--rigs N]
// What plays the base and holds the stop-watch runs at a priority that nobody disturbs, like the hardware that it
// stands for. Rigs work at the same time, each a process with a pseudo-terminal and a base of its own. On a real line
// the 7 ms that a packet takes at 115200 baud come on top.
#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "hal/kobuki/base_thread.hpp"
#include "hal/linux/serial_port.hpp"
#include "tests/support/command_tap.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/scripted_base.hpp"

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr TimeNs kPatience_ns = 5'000 * kMs;

enum Kind { kFlag, kSilent, kStale, kKilled, kStopped, kJitter, kKinds };
struct KindRow {
  const char* name;
  double limit_ms;  // of the maximum; for the jitter of p99
};
constexpr std::array<KindRow, kKinds> kRows{{{"bumper, cliff, wheel drop -> zero", 25.0},
                                             {"silent line -> zero", 60.0},
                                             {"stale command -> zero", 200.0},
                                             {"kill -9 -> fifth zero", 500.0},
                                             {"SIGSTOP -> fifth zero", 500.0},
                                             {"jitter of the 20 ms tick (p99)", 2.0}}};

struct Sample {
  int kind = 0;
  TimeNs latency_ns = 0;  // < 0: nothing came
};

struct Rng {  // xorshift64: causes at all phases of the period
  std::uint64_t state;
  std::uint64_t below(std::uint64_t limit) {
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return state % limit;
  }
};

void pause_ns(TimeNs ns) {
  RealClock clock;
  clock.sleep_until(clock.now() + ns);
}

/// False if the system does not grant it. New threads and processes inherit it.
bool set_priority(int priority) {
  const sched_param parameters{priority};
  return ::sched_setscheduler(0, priority > 0 ? SCHED_FIFO : SCHED_OTHER, &parameters) == 0;
}
constexpr int kHardwarePriority = 60;

/// What drives: port, thread, and somebody who commands and sees.
struct Driver {
  RealClock clock;
  SerialPort port;
  std::optional<LineGuard> guard;
  std::unique_ptr<BaseThread> base;
  std::atomic<bool> commander{true}, ending{false};
  std::atomic<TimeNs> last_command_ns{0};
  std::thread others;

  Driver(const std::string& path, bool with_guard)
      : port({[path]() -> Result<std::string> { return path; }, {}, 100 * kMs}, clock) {
    if (!port.open().ok()) std::abort();
    if (with_guard) {
      auto started = LineGuard::start(port.fd());
      if (!started.ok()) std::abort();
      guard.emplace(std::move(started.value()));
    }
    BaseThreadOptions options;
    options.driver.times.wheels_up_ns = 100 * kMs;  // so that a trial does not last for seconds
    base = std::make_unique<BaseThread>(port, clock, options, guard ? &*guard : nullptr);
    base->start();
    others = std::thread([this] {
      while (!ending.load()) {
        const TimeNs now_ns = clock.now();
        base->set_camera_alive(now_ns);
        if (commander.load()) {
          base->set_command({0.3, 0.2}, now_ns);
          last_command_ns.store(now_ns);
        }
        clock.sleep_until(now_ns + 10 * kMs);
      }
    });
  }
  ~Driver() {
    ending.store(true);
    others.join();
    base->stop();
  }
};

/// One rig: a process with a base of its own, which writes its samples into `out_fd`.
class Rig {
 public:
  Rig(int out_fd, std::uint64_t seed, int trials) : out_fd_(out_fd), random_{seed * 7919 + 1}, trials_(trials) {}

  void run() {
    if (!set_priority(kHardwarePriority))
      fmt::print(stderr, "no realtime priority: figures include the machine's load\n");
    for (int i = 0; i < trials_; ++i) {  // first, while this process has one thread
      guard_trial(kKilled, SIGKILL);
      guard_trial(kStopped, SIGSTOP);
    }
    thread_trials();
  }

 private:
  void say(Kind kind, TimeNs latency_ns) const {
    const Sample sample{kind, latency_ns};
    if (::write(out_fd_, &sample, sizeof sample) != sizeof sample) ::_exit(1);
  }

  void guard_trial(Kind kind, int signal) {
    const test::PtyPair pty;
    const pid_t process = ::fork();
    if (process < 0) std::abort();
    if (process == 0) {
      (void)set_priority(0);
      Driver driver(pty.path(), true);
      for (;;) pause_ns(1'000 * kMs);
    }
    {
      const test::ScriptedBase device(pty.fd());
      test::CommandTap tap(pty.fd());
      TimeNs latency_ns = -1;
      if (tap.wait_for_motion(kPatience_ns) != 0) {
        pause_ns(static_cast<TimeNs>(100'000'000 + random_.below(20'000'000)));
        const TimeNs start_ns = RealClock().now();
        ::kill(process, signal);
        // What was under way before the cause may still be read, but it is no zero.
        TimeNs zero_ns = 0;
        for (int i = 0; i < 5; ++i) zero_ns = tap.wait_for_zero(kPatience_ns);
        if (zero_ns != 0) latency_ns = zero_ns - start_ns;
      }
      say(kind, latency_ns);
    }
    ::kill(process, SIGKILL);
    ::waitpid(process, nullptr, 0);
  }

  void thread_trials() {
    const test::PtyPair pty;
    (void)set_priority(0);
    Driver driver(pty.path(), false);
    (void)set_priority(kHardwarePriority);
    test::ScriptedBase device(pty.fd());
    test::CommandTap tap(pty.fd());
    for (int i = 0; i < trials_; ++i) {
      if (get_going(tap)) flag_trial(device, tap, i);
      device.set_flags(0, 0, 0);
      if (get_going(tap)) {
        device.set_silent(true);
        const TimeNs zero_ns = tap.wait_for_zero(kPatience_ns);
        say(kSilent, zero_ns == 0 ? -1 : zero_ns - device.last_sent_ns());
        device.set_silent(false);
      }
      if (get_going(tap)) {
        driver.commander.store(false);
        const TimeNs zero_ns = tap.wait_for_zero(kPatience_ns);
        say(kStale, zero_ns == 0 ? -1 : zero_ns - driver.last_command_ns.load());
        driver.commander.store(true);
      }
    }
    if (!get_going(tap)) return;
    TimeNs last_ns = tap.wait_for_motion(kPatience_ns);
    for (int i = 0; i < trials_; ++i) {
      const TimeNs t_ns = tap.wait_for_motion(kPatience_ns);
      say(kJitter, std::abs(t_ns - last_ns - kPacketPeriod_ns));
      last_ns = t_ns;
    }
  }

  /// Drives, and at a phase of the period that is not always the same.
  [[nodiscard]] bool get_going(test::CommandTap& tap) {
    tap.drain();
    if (tap.wait_for_motion(kPatience_ns) == 0) return false;
    pause_ns(static_cast<TimeNs>(40'000'000 + random_.below(20'000'000)));
    tap.drain();
    return tap.wait_for_motion(kPatience_ns) != 0;
  }

  void flag_trial(test::ScriptedBase& device, test::CommandTap& tap, int i) const {
    device.set_flags(i % 3 == 0 ? kBumperLeft : 0, i % 3 == 1 ? kCliffRight : 0, i % 3 == 2 ? kWheelDropLeft : 0);
    const TimeNs zero_ns = tap.wait_for_zero(kPatience_ns);
    const TimeNs sent_ns = device.flags_sent_ns();
    if (zero_ns != 0 && sent_ns == 0) return;  // it stood already, as a thread was late: no answer to this flag
    say(kFlag, zero_ns == 0 ? -1 : zero_ns - sent_ns);
  }

  const int out_fd_;
  Rng random_;
  const int trials_;
};

int report(std::array<std::vector<TimeNs>, kKinds>& samples) {
  int failed = 0;
  fmt::print("{:<36}{:>8}{:>10}{:>10}{:>10}{:>10}\n", "ms", "trials", "p50", "p99", "max", "limit");
  for (int kind = 0; kind < kKinds; ++kind) {
    auto& values = samples[static_cast<std::size_t>(kind)];
    const KindRow& row = kRows[static_cast<std::size_t>(kind)];
    if (values.empty()) {
      ++failed;
      continue;
    }
    std::sort(values.begin(), values.end());
    const auto at_ms = [&](double part) {
      return static_cast<double>(values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))]) *
             1e-6;
    };
    const double judged_ms = kind == kJitter ? at_ms(0.99) : at_ms(1.0);
    const bool good = values.front() >= 0 && judged_ms <= row.limit_ms;
    failed += !good;
    fmt::print("{:<36}{:>8}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.0f}  {}\n", row.name, values.size(), at_ms(0.5),
               at_ms(0.99), at_ms(1.0), row.limit_ms, good ? "kept" : "BROKEN");
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int trials = 1'000, rigs = 8;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--trials") == 0) trials = std::max(1, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--rigs") == 0) rigs = std::clamp(std::atoi(argv[i + 1]), 1, 64);
  }
  std::array<int, 2> pipe_fds{};
  if (::pipe2(pipe_fds.data(), O_CLOEXEC) != 0) return 1;
  std::vector<pid_t> processes;
  for (int i = 0; i < rigs; ++i) {
    const pid_t process = ::fork();
    if (process < 0) return 1;
    if (process == 0) {
      ::close(pipe_fds[0]);
      Rig(pipe_fds[1], static_cast<std::uint64_t>(i) + 1, (trials + rigs - 1) / rigs).run();
      ::_exit(0);
    }
    processes.push_back(process);
  }
  ::close(pipe_fds[1]);
  std::array<std::vector<TimeNs>, kKinds> samples;
  Sample sample;
  while (::read(pipe_fds[0], &sample, sizeof sample) == sizeof sample) {
    samples[static_cast<std::size_t>(sample.kind)].push_back(sample.latency_ns);
  }
  for (const pid_t process : processes) ::waitpid(process, nullptr, 0);
  return report(samples);
}
