// SPDX-License-Identifier: Apache-2.0
// The real line, end to end: a process that drives as the robot does (port, thread, guard) at the pseudo-terminal of a
// base in a simulated building that runs in real time. It is killed, stopped, ended and unplugged; the base must stand.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <functional>
#include <string>

#include "hal/kobuki/base_thread.hpp"
#include "hal/linux/serial_port.hpp"
#include "hal/sim/real_time_building.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::hal::kobuki;

namespace {

constexpr TimeNs kMs = 1'000'000;

std::atomic<bool> asked_to_end{false};

/// The robot's process: drives a circle until it is ended by a signal.
[[noreturn]] void drive(const std::string& link) {
  ::signal(SIGTERM, [](int) { asked_to_end.store(true); });
  {
    RealClock clock;
    auto guard = LineGuard::start(-1);
    if (!guard.ok()) ::_exit(3);
    SerialPort port(
        {[&]() -> Result<std::string> { return link; }, [&](int fd) { (void)guard.value().hand_over(fd); }, 50 * kMs},
        clock);
    BaseThread base(port, clock, {}, &guard.value());
    base.start();
    while (!asked_to_end.load()) {
      base.set_command({0.3, 0.5}, clock.now());
      base.set_camera_alive(clock.now());
      clock.sleep_until(clock.now() + 20 * kMs);
    }
    base.stop();
  }
  ::_exit(0);
}

World hall() {
  World world;
  world.add_floor({0.0, 0.0, 0.0}, 20.0, 20.0, 0.1, {});
  return world;
}

struct Robot {
  test::TempFolder folder;
  std::string link = folder / "kobuki";
  pid_t process;
  RealClock clock;
  std::unique_ptr<RealTimeBuilding> building;

  Robot() : process(::fork()) {  // before this process has threads
    if (process < 0) std::abort();
    if (process == 0) drive(link);
    SimBuildingOptions options;
    options.camera = scaled_kinect(64, 48);
    options.robots.resize(1);
    auto started = RealTimeBuilding::start(hall(), options, clock, {link});
    if (!started.ok()) std::abort();
    building = std::move(started.value());
    REQUIRE(within_ms(3'000, [&] { return speed_mps() > 0.25; }));
  }
  ~Robot() { end(SIGKILL); }

  void send(int signal) const {
    if (process > 1) ::kill(process, signal);
  }
  int end(int signal) {
    int status = -1;
    if (process <= 1) return status;
    send(signal);
    ::waitpid(process, &status, 0);
    process = -1;
    return status;
  }
  double speed_mps() {
    return building->with(0, [](SimBuilding& b, BaseCable&) { return b.body(0).velocity().forward_mps; });
  }
  bool is_told_to_stand() {
    return building->with(0, [](SimBuilding& b, BaseCable&) { return b.kobuki(0).drive() == BaseControl{}; });
  }
  bool within_ms(int limit_ms, const std::function<bool()>& condition) {
    const TimeNs end_ns = clock.now() + limit_ms * kMs;
    while (!condition()) {
      if (clock.now() >= end_ns) return false;
      clock.sleep_until(clock.now() + 5 * kMs);
    }
    return true;
  }
};

}  // namespace

TEST_CASE("Killed while driving: the base is told to stand within half a second") {
  Robot robot;
  robot.end(SIGKILL);
  CHECK(robot.within_ms(500, [&] { return robot.is_told_to_stand(); }));
  CHECK(robot.within_ms(1'000, [&] { return robot.speed_mps() == Approx(0.0).margin(1e-3); }));
}

TEST_CASE("Stopped while driving: it stands within half a second, and drives on when it is continued") {
  Robot robot;
  robot.send(SIGSTOP);
  CHECK(robot.within_ms(500, [&] { return robot.is_told_to_stand(); }));
  robot.clock.sleep_until(robot.clock.now() + 300 * kMs);
  CHECK(robot.is_told_to_stand());
  robot.send(SIGCONT);
  CHECK(robot.within_ms(2'000, [&] { return robot.speed_mps() > 0.25; }));
}

TEST_CASE("Ended as it should be: it stands when the process is gone") {
  Robot robot;
  const int status = robot.end(SIGTERM);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(robot.within_ms(100, [&] { return robot.is_told_to_stand(); }));
}

TEST_CASE(
    "Unplugged while driving: stopped as soon as it is plugged in again, then it drives on; and the guard moved "
    "along") {
  Robot robot;
  robot.building->with(0, [](SimBuilding&, BaseCable& cable) { cable.pull_out(); });
  robot.clock.sleep_until(robot.clock.now() + 300 * kMs);
  CHECK(robot.speed_mps() > 0.25);  // nobody can tell it
  robot.building->with(0, [](SimBuilding&, BaseCable& cable) { REQUIRE(cable.plug_in().ok()); });
  CHECK(robot.within_ms(1'000, [&] { return robot.is_told_to_stand(); }));
  CHECK(robot.within_ms(2'000, [&] { return robot.speed_mps() > 0.25; }));
  robot.end(SIGKILL);
  CHECK(robot.within_ms(500, [&] { return robot.is_told_to_stand(); }));
}
