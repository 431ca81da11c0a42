// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/base_thread.hpp"

#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "hal/linux/serial_port.hpp"
#include "tests/support/command_tap.hpp"
#include "tests/support/pty_pair.hpp"
#include "tests/support/scripted_base.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;
using namespace g3d::hal::kobuki;
using test::CommandTap;
using test::PtyPair;
using test::ScriptedBase;

namespace {

constexpr TimeNs kMs = 1'000'000;
// How long a test waits for what must come; how fast it must come is the benchmark's business.
constexpr TimeNs kPatience_ns = 5'000 * kMs;

bool becomes_true(const std::function<bool()>& condition) {
  RealClock clock;
  const TimeNs end_ns = clock.now() + kPatience_ns;
  while (clock.now() < end_ns) {
    if (condition()) return true;
    clock.sleep_until(clock.now() + 2 * kMs);
  }
  return condition();
}

// A commander and a camera in a thread of their own, that may be told to fall silent.
struct Others {
  explicit Others(BaseThread& base)
      : thread([this, &base] {
          RealClock clock;
          while (!ending.load()) {
            if (commander.load()) base.set_command({0.2, 0.1}, clock.now());
            if (camera.load()) base.set_camera_alive(clock.now());
            clock.sleep_until(clock.now() + 20 * kMs);
          }
        }) {}
  ~Others() {
    ending.store(true);
    thread.join();
  }
  std::atomic<bool> ending{false}, commander{true}, camera{true};
  std::thread thread;
};

struct Robot {
  PtyPair pty;
  RealClock clock;
  SerialPort port{{[this]() -> Result<std::string> { return pty.path(); }, {}, 100 * kMs}, clock};
  ScriptedBase device{pty.fd()};
  CommandTap tap{pty.fd()};
  BaseThread base;
  std::unique_ptr<Others> others;

  explicit Robot(LineGuard* guard = nullptr, LineRecorder* recorder = nullptr)
      : base(port, clock, options(), guard, recorder) {
    begin();
    REQUIRE(tap.wait_for_motion(kPatience_ns) != 0);
  }
  explicit Robot(std::vector<SafetyDevice*> devices) : base(port, clock, options(std::move(devices))) { begin(); }
  void begin() {
    REQUIRE(port.open().ok());
    base.start();
    others = std::make_unique<Others>(base);
  }
  static BaseThreadOptions options(std::vector<SafetyDevice*> devices = {}) {
    BaseThreadOptions options;
    options.safety_devices = std::move(devices);
    // Under a sanitizer, with everybody else on the machine, this thread may be late; that is another test.
    options.driver.times.late_thread_ns = 1'000 * kMs;
    options.driver.times.late_base_ns = 1'000 * kMs;
    options.driver.times.silent_base_ns = 400 * kMs;
    return options;
  }
  BaseState state() const {
    BaseState state;
    (void)base.state().read(state);
    return state;
  }
  bool stands_because_of(Condition condition) {
    if (tap.wait_for_zero(kPatience_ns) == 0) return false;
    return becomes_true([&] { return state().conditions.has(condition); });
  }
};

}  // namespace

TEST_CASE("It drives, reads and publishes on its own", "[threads]") {
  Robot robot;
  robot.device.set_ticks(20);
  CHECK(becomes_true([&] { return robot.state().T_world_base.x_m > 0.02; }));
  CHECK(robot.state().verdict.state == SafetyState::free);
  CHECK(robot.state().packets > 10);
  PoseHistory poses;
  REQUIRE(robot.base.poses().read(poses) > 0);
  const BaseState state = robot.state();
  REQUIRE(robot.base.poses().read(poses) > 0);
  const auto pose = poses.at(state.feedback_ns);
  REQUIRE(pose);
  CHECK(pose->x_m == Approx(state.T_world_base.x_m).margin(0.01));
  BaseThreadHealth health;
  CHECK(robot.base.health().read(health) > 0);
  CHECK(health.line_is_up);
  CHECK(health.refused_writes == 0);
}

TEST_CASE("A bumper in the bytes is a zero in the bytes", "[threads]") {
  Robot robot;
  robot.device.set_flags(kBumperCentre, 0, 0);
  CHECK(robot.stands_because_of(Condition::bumper));
  robot.device.set_flags(0, 0, 0);
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
}

TEST_CASE("Each that falls silent stops it, each that comes back lets it go on", "[threads]") {
  Robot robot;
  robot.others->commander.store(false);
  CHECK(robot.stands_because_of(Condition::stale_command));
  robot.others->commander.store(true);
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
  robot.others->camera.store(false);
  CHECK(robot.stands_because_of(Condition::silent_camera));
  robot.others->camera.store(true);
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
  robot.device.set_silent(true);
  CHECK(robot.stands_because_of(Condition::silent_base));
  robot.device.set_silent(false);
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
}

TEST_CASE("The base's own thread asks stop devices, shows them the robot and says farewell", "[threads]") {
  class Switch final : public SafetyDevice {
   public:
    StopWord look(TimeNs) override { return word.load(); }
    void show(const SafetyNews& news, TimeNs) override { state.store(news.state); }
    void say_farewell(TimeNs) override { farewells.fetch_add(1); }
    std::atomic<StopWord> word{StopWord::not_yet};
    std::atomic<SafetyState> state{SafetyState::free};
    std::atomic<int> farewells{0};
  };
  Switch first, second;
  second.word = StopWord::go;
  Robot robot({&first, &second});
  Others& others = *robot.others;
  CHECK(others.commander.load());
  CHECK(robot.tap.wait_for_motion(200 * kMs) == 0);  // not seen yet: it stands
  CHECK(becomes_true([&] { return robot.state().conditions.has(Condition::e_stop); }));
  CHECK(first.state == SafetyState::stand);
  first.word = StopWord::go;  // and nobody has to resume
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
  CHECK(becomes_true([&] { return second.state == SafetyState::free; }));
  second.word = StopWord::stop;
  CHECK(robot.stands_because_of(Condition::e_stop));
  second.word = StopWord::go;
  CHECK(robot.tap.wait_for_motion(200 * kMs) == 0);  // latched
  robot.base.resume();
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
  robot.base.stop();
  CHECK(first.farewells == 1);
  CHECK(second.farewells == 1);
}

TEST_CASE("An e-stop, however short, holds until somebody resumes", "[threads]") {
  Robot robot;
  robot.base.set_e_stop(true);
  robot.base.set_e_stop(false);
  CHECK(robot.stands_because_of(Condition::e_stop));
  robot.tap.drain();
  for (const auto& packet : robot.tap.listen(200 * kMs)) CHECK(packet.is_zero_speed());
  robot.base.set_e_stop(true);
  robot.base.resume();
  CHECK(robot.tap.wait_for_motion(100 * kMs) == 0);
  robot.base.set_e_stop(false);
  robot.base.resume();
  CHECK(robot.tap.wait_for_motion(kPatience_ns) != 0);
}

TEST_CASE("At the end come five zeros, and nothing after them", "[threads]") {
  for (const bool by_destructor : {false, true}) {
    auto robot = std::make_unique<Robot>();
    robot->tap.drain();
    const int fd = ::dup(robot->pty.fd());
    CommandTap tap(fd);
    if (by_destructor) {
      robot->others.reset();
      // The far end closes with the robot: what the base thread says must be read before.
      robot->base.stop();
    } else {
      robot->base.stop();
      robot->base.stop();
    }
    const auto packets = tap.listen(100 * kMs);
    REQUIRE(packets.size() >= 5);
    std::size_t zeros = 0;
    for (std::size_t i = packets.size() - 5; i < packets.size(); ++i) zeros += packets[i].is_zero_speed();
    CHECK(zeros == 5);
    robot->base.start();  // not again
    CHECK(tap.listen(60 * kMs).empty());
    robot.reset();
    ::close(fd);
  }
}

TEST_CASE("Unplugged and plugged in again it goes on, and has counted", "[threads]") {
  auto first = std::make_unique<PtyPair>();
  const PtyPair second;
  std::atomic<bool> use_second{false};
  RealClock clock;
  const std::string paths[] = {first->path(), second.path()};
  SerialPort port({[&]() -> Result<std::string> { return paths[use_second.load() ? 1 : 0]; }, {}, 20 * kMs}, clock);
  auto device = std::make_unique<ScriptedBase>(first->fd());
  BaseThread base(port, clock, Robot::options());
  base.start();  // the line opens when it is there
  Others others(base);
  {
    CommandTap tap(first->fd());
    CHECK(tap.wait_for_motion(kPatience_ns) != 0);
  }
  device.reset();
  first.reset();
  const auto health = [&] {
    BaseThreadHealth value;
    (void)base.health().read(value);
    return value;
  };
  CHECK(becomes_true([&] { return health().line_losses == 1 && !health().line_is_up; }));
  use_second.store(true);
  ScriptedBase other_device(second.fd());
  CommandTap tap(second.fd());
  int zeros = 0;
  test::SentPacket packet;
  while (tap.next(packet, kPatience_ns) && packet.is_zero_speed()) ++zeros;
  CHECK(zeros >= 5);  // the base kept the last command while nobody could tell it otherwise
  CHECK(packet.is_base_control());
  base.stop();
}

TEST_CASE("What came over the line can be recorded", "[threads]") {
  const test::TempFolder folder;
  auto recorder = LineRecorder::create(folder / "kobuki.bin");
  REQUIRE(recorder.ok());
  std::uint64_t received_bytes = 0;
  {
    Robot robot(nullptr, recorder.value().get());
    robot.others.reset();
    robot.base.stop();
    received_bytes = robot.state().received_bytes;
  }
  REQUIRE(recorder.value()->finish().ok());
  CHECK(received_bytes > 0);
  CHECK(recorder.value()->lost_bytes() == 0);
  CHECK(test::read_plain(folder / "kobuki.bin").size() > received_bytes);
}

TEST_CASE("It beats for the guard, which stays silent", "[threads]") {
  auto guard = LineGuard::start(-1);
  REQUIRE(guard.ok());
  Robot robot(&guard.value());
  CHECK(guard.value().hand_over(robot.port.fd()));
  robot.clock.sleep_until(robot.clock.now() + 300 * kMs);
  CHECK(guard.value().zeros_sent() == 0);
  CHECK(guard.value().alive());
}
