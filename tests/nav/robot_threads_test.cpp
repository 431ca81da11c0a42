// SPDX-License-Identifier: Apache-2.0
#include "nav/robot_threads.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "hal/progress_board.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/reach.hpp"
#include "hal/sim/sim_building.hpp"

using namespace g3d;
using namespace g3d::nav;

namespace {

constexpr hal::TimeNs kMs = 1'000'000;
constexpr hal::TimeNs kPatience_ns = 20'000 * kMs;  // for sanitizers on a busy machine

hal::SimBuildingOptions one_robot(const hal::World& world, double battery_V) {
  hal::SimBuildingOptions options;
  options.camera = hal::scaled_kinect(48, 36);
  options.robots.resize(1);
  options.robots[0].base.battery_V = battery_V;
  options.robots[0].T_world_base = hal::choose_starts(world, 1, 1).value()[0];
  return options;
}

/// A building that moves on whenever somebody at the line or behind the camera looks at it: no thread of its own.
struct Place final : hal::ByteLine, hal::DepthCamera {
  Place(const hal::World& world, double battery_V) : options(one_robot(world, battery_V)), building(world, options) {}

  [[nodiscard]] std::size_t read(std::span<std::uint8_t> into) override {
    const std::lock_guard lock(mutex);
    move_on();
    return building.line(0).read(into);
  }
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) override {
    const std::lock_guard lock(mutex);
    return building.line(0).write(bytes);
  }
  [[nodiscard]] hal::LineState state() const override { return hal::LineState::up; }

  [[nodiscard]] const hal::CameraModel& model() const override { return options.camera; }
  [[nodiscard]] hal::CameraRead read(hal::Frame& out) override {
    clock.sleep_until(clock.now() + frame_period_ns.load());
    if (ended.load()) return {hal::CameraEvent::end, {}};
    if (++frames % 10 == 0) return {hal::CameraEvent::dropped, hal::DropReason::wrong_size};
    const std::lock_guard lock(mutex);
    move_on();
    building.render(0, out);
    out.stamp_ns += begin_ns;
    return {hal::CameraEvent::frame, {}};
  }

  void move_on() { building.advance_to(clock.now() - begin_ns); }
  hal::kobuki::BaseControl drive() {
    const std::lock_guard lock(mutex);
    move_on();
    return building.kobuki(0).drive();
  }
  double driven_m() {
    const std::lock_guard lock(mutex);
    return building.record(0).driven_m + building.record(0).turned_rad;
  }

  hal::RealClock clock;
  const hal::TimeNs begin_ns = clock.now();
  const hal::SimBuildingOptions options;
  std::mutex mutex;
  hal::SimBuilding building;
  std::atomic<hal::TimeNs> frame_period_ns{80 * kMs};
  std::atomic<bool> ended{false};
  std::uint64_t frames = 0;  // the camera thread's
};

struct Live {
  explicit Live(double battery_V = 16.0, const std::function<void(RobotConfig&)>& with = {})
      : place(hal::load_world("two_rooms").value(), battery_V),
        robot(config(place, with, board.add("navigator", 300 * kMs)), parts()) {}
  Place place;
  hal::ProgressBoard board;
  RobotThreads robot;

  static RobotThreadsConfig config(const Place& place, const std::function<void(RobotConfig&)>& with,
                                   hal::ProgressEntry& navigator) {
    RobotThreadsConfig config;
    config.navigator_progress = &navigator;
    config.robot.mapper.resolution_m = 0.1F;
    config.robot.mapper.capacity = mapper::capacity_for_bytes(32'000'000);
    config.robot.mapper.threads = 1;
    config.robot.camera = place.options.camera;
    config.robot.T_base_camera = place.options.robots[0].T_base_camera;
    config.robot.T_world_start = place.options.robots[0].T_world_base;
    config.robot.navigator.ground.centre_x_m = config.robot.T_world_start.x_m;
    config.robot.navigator.ground.centre_y_m = config.robot.T_world_start.y_m;
    config.robot.navigator.ground.max_slots = config.robot.mapper.capacity.blocks;
    // Under a sanitizer, with everybody else on the machine, threads are late; the safety table has its own tests.
    hal::SafetyTimes& times = config.robot.driver.times;
    times.late_thread_ns = times.late_base_ns = times.silent_base_ns = 2'000 * kMs;
    times.silent_camera_ns = times.stale_command_ns = 2'000 * kMs;
    config.robot.frame_watch.max_age_ns = 2'000 * kMs;
    config.coverage_period_ns = 100 * kMs;
    if (with) with(config.robot);
    return config;
  }
  RobotParts parts() {
    RobotParts parts{place, place, place.clock, [this] { place.ended.store(true); }, nullptr, nullptr, {}};
    parts.coverage = [this](const GroundMap&) { return 0.01 * ++asked; };
    parts.on_mapped = [this](const hal::MappedNote&, const hal::Frame*) {
      while (mapper_hangs.load()) place.clock.sleep_until(place.clock.now() + 5 * kMs);
    };
    return parts;
  }
  bool becomes_true(const std::function<bool()>& condition) {
    const hal::TimeNs end_ns = place.clock.now() + kPatience_ns;
    while (!condition()) {
      if (place.clock.now() >= end_ns) return false;
      place.clock.sleep_until(place.clock.now() + 5 * kMs);
    }
    return true;
  }
  std::atomic<int> asked{0};
  std::atomic<bool> mapper_hangs{false};
};

const mapper::StageTimes& times_of(const std::vector<mapper::NamedStage>& stages, const std::string& name) {
  for (const mapper::NamedStage& stage : stages) {
    if (stage.name == name) return stage.times;
  }
  throw std::runtime_error("no stage " + name);
}

}  // namespace

TEST_CASE("a robot whose mapper hangs stands, though its camera sees and its navigator would go on", "[threads]") {
  Live live;
  live.robot.start();
  REQUIRE(live.becomes_true([&] { return live.place.driven_m() > 0.5; }));
  live.mapper_hangs = true;
  const auto stands = [&] {
    const double driven_m = live.place.driven_m();
    live.place.clock.sleep_until(live.place.clock.now() + 500 * kMs);
    return live.place.drive() == hal::kobuki::BaseControl{} && live.place.driven_m() == driven_m;
  };
  CHECK(live.becomes_true(stands));
  CHECK(stands());
  // And who feeds the watchdog hears of it.
  CHECK(live.becomes_true([&] { return live.board.find_late(live.place.clock.now()).name != nullptr; }));
  live.mapper_hangs = false;
  const double driven_m = live.place.driven_m();
  CHECK(live.becomes_true([&] { return live.place.driven_m() > driven_m + 0.2; }));
  live.robot.stop();
}

TEST_CASE("in threads, the robot looks around by itself, and stands when it is stopped", "[threads]") {
  Live live;
  live.robot.start();
  REQUIRE(live.becomes_true([&] { return live.place.driven_m() > 0.5; }));
  LiveStatus status;
  REQUIRE(live.becomes_true([&] { return live.robot.status().read(status) > 2; }));
  CHECK(status.coverage > 0.0);
  live.robot.stop();
  CHECK(live.becomes_true([&] { return live.place.drive() == hal::kobuki::BaseControl{}; }));
  live.robot.stop();  // changes nothing

  const mapper::FrameCounts frames = live.robot.frames();
  CHECK(frames.balanced());
  CHECK(frames.integrated > 0);
  CHECK(frames.dropped[static_cast<std::size_t>(hal::DropReason::wrong_size)] == frames.delivered / 10);
  CHECK(live.robot.mapper().map().counts().free > 0);
  CHECK(live.robot.navigator().report().coverage().size() > 1);
  std::uint64_t poses = 0;
  hal::StampedPose pose, before;
  for (; live.robot.next_pose(pose); ++poses) {
    CHECK(pose.stamp_ns > before.stamp_ns);
    CHECK(pose.T_world_camera.translation_m[2] == Approx(0.5));
    before = pose;
  }
  CHECK(poses == frames.integrated);
  const auto stages = live.robot.stages();
  CHECK(times_of(stages, "integrate").count() == frames.integrated);
  CHECK(times_of(stages, "ground").count() == frames.integrated);
  CHECK(times_of(stages, "read").count() == frames.delivered);
  CHECK(times_of(stages, "navigate").count() > 0);
  hal::kobuki::BaseState base;
  (void)live.robot.base().state().read(base);
  CHECK(times_of(stages, "control_jitter").count() + 1 >= base.ticks);
  CHECK(base.packets > 0);
}

TEST_CASE("a mapper that is behind loses the oldest frames, counts them, and the robot drives on", "[threads]") {
  Live live;
  live.place.frame_period_ns.store(0);  // frames come as fast as they can be drawn
  live.robot.start();
  const auto lost = [&] { return live.robot.frames().dropped[static_cast<std::size_t>(hal::DropReason::queue_full)]; };
  CHECK(live.becomes_true([&] { return lost() > 0 && live.place.driven_m() > 0.3; }));
  live.robot.stop();
  CHECK(lost() > 0);
  CHECK(live.robot.frames().integrated > 0);
  CHECK(live.robot.frames().balanced());
}

TEST_CASE("a camera that ends is seen, and what it gave is in the map", "[threads]") {
  Live live;
  live.robot.start();
  REQUIRE(live.becomes_true([&] { return live.robot.frames().integrated > 2; }));
  CHECK_FALSE(live.robot.camera_has_ended());
  live.place.ended.store(true);
  CHECK(live.becomes_true([&] { return live.robot.camera_has_ended(); }));
  live.robot.stop();
  CHECK(live.robot.frames().balanced());
}

TEST_CASE("a robot whose battery is low does not explore, it goes home", "[threads]") {
  Live live(13.7);
  live.robot.start();
  LiveStatus status;
  CHECK(live.becomes_true([&] {
    (void)live.robot.status().read(status);
    return status.state == MissionState::returning || status.state == MissionState::home;
  }));
  live.robot.stop();
}

TEST_CASE("people's words reach a robot that runs", "[threads]") {
  Live live;
  live.robot.start();
  LiveStatus status;
  REQUIRE(live.becomes_true([&] { return live.robot.status().read(status) > 2; }));
  const auto says = [&](const char* word, const char* state) {
    return live.becomes_true([&] { return live.robot.hotline().answer(word).find(state) != std::string::npos; });
  };
  CHECK(says("pause", "\"state\": \"paused\""));
  CHECK(says("resume", "\"purpose\": \"starting\""));
  CHECK(says("stop", "\"state\": \"stopped\""));
  CHECK(says("home", "\"purpose\": \"returning\""));
  live.robot.stop();
  CHECK(live.robot.navigator().mission().state() == MissionState::stopped);
  for (const ThreadTime& time : live.robot.thread_times()) {
    INFO(time.name);
    if (std::string(time.name) != "mapper_workers") CHECK(time.cpu_s > 0.0);
  }
}

TEST_CASE("a robot that was never started stops, and one that was stopped is not started again", "[threads]") {
  Live live;
  live.robot.stop();
  live.robot.start();
  CHECK(live.robot.frames().delivered == 0);
  CHECK_FALSE(live.robot.camera_has_ended());
}

namespace {

/// Submaps after a part of a turn, and every loop is worth a move: so that there are some within seconds.
void has_many_loops(RobotConfig& config) {
  config.align.emplace();
  config.align->surface.slots = std::size_t{1} << 16;
  config.loops.emplace();
  config.loops->chain = {.most_way_m = 0.5, .most_turn_rad = 0.7, .most_s = 1.0};
  config.loops->answer_after_ns = 0;
  config.loops->most_blocks_per_frame = 20;
  mapper::submaps::CloserOptions& closer = config.loops->closer;
  closer.finder.least_age = 1;
  closer.finder.most_candidates = 4;
  closer.finder.most_apart_m = closer.most_off_m = 0.5;
  closer.finder.most_apart_rad = closer.most_off_rad = 0.5;
  closer.least_move_m = closer.least_turn_rad = 0.0;
}

}  // namespace

TEST_CASE("in threads, the map is put right while the robot stands, and every frame is accounted for",
          "[threads][slow]") {
  Live live(16.0, has_many_loops);
  live.place.frame_period_ns = 30 * kMs;
  live.robot.start();
  const auto moved = [&] { return live.robot.frames().dropped[static_cast<std::size_t>(hal::DropReason::map_moving)]; };
  CHECK(live.becomes_true([&] { return moved() > 3; }));
  const double before_m = live.place.driven_m();
  CHECK(live.becomes_true([&] { return live.place.driven_m() > before_m + 0.3; }));  // and it goes on
  live.robot.stop();
  REQUIRE(live.robot.loops() != nullptr);
  const mapper::submaps::CloserReport report = live.robot.loops()->report();
  CHECK(report.corrections > 0);
  CHECK(live.robot.frames().balanced());
}

namespace {

/// The robot's own map as if it were shared; counts who asks. Every other turn there are news: the same blocks again.
struct EchoSight final : SharedSight {
  std::span<const std::uint32_t> on_own(const mapper::VoxelMap& own, std::span<const std::uint32_t> slots) override {
    shown = &own;
    last = slots;
    ++own_turns;
    return slots;
  }
  std::span<const std::uint32_t> take_news() override {
    return ++news_turns % 2 == 0 ? last : std::span<const std::uint32_t>{};
  }
  [[nodiscard]] const mapper::VoxelMap& map() const override { return *shown; }
  const mapper::VoxelMap* shown = nullptr;
  std::span<const std::uint32_t> last;
  std::uint64_t own_turns = 0;
  std::uint64_t news_turns = 0;
};

}  // namespace

TEST_CASE("submaps are lent to who shares them, and the map is put right all the same", "[threads]") {
  EchoSight sight;
  Live live(16.0, has_many_loops);
  live.place.frame_period_ns = 30 * kMs;
  live.robot.share(sight, [](std::span<const std::uint32_t>) {});
  const mapper::submaps::DrivingLoops* const loops = live.robot.loops();
  REQUIRE(loops != nullptr);
  live.robot.start();
  std::atomic<bool> is_over{false};
  std::size_t submaps = 0;
  std::uint64_t times = 0;
  std::uint64_t noted = 0;
  std::thread borrower([&] {
    while (!is_over.load()) {
      if (loops->try_borrow_chain()) {
        const mapper::submaps::SubmapChain& chain = loops->chain();
        submaps = std::max(submaps, chain.submaps().size());
        for (const mapper::submaps::Submap& submap : chain.submaps()) times += submap.last_ns > submap.first_ns ? 1 : 0;
        for (std::uint32_t slot = 0; slot < chain.view().slot_end(); ++slot) {
          noted += chain.recorder().is_noted(slot) ? 1 : 0;
        }
        loops->give_back_chain();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const auto moved = [&] { return live.robot.frames().dropped[static_cast<std::size_t>(hal::DropReason::map_moving)]; };
  CHECK(live.becomes_true([&] { return moved() > 3; }));
  live.robot.stop();
  is_over.store(true);
  borrower.join();
  CHECK(loops->report().corrections > 0);
  CHECK(live.robot.frames().balanced());
  CHECK(submaps > 1);
  CHECK(times > 0);
  CHECK(noted > 0);
}

TEST_CASE("in threads, a robot that shares drives by what it is shown, and every frame's changes are told",
          "[threads]") {
  Live live;
  EchoSight sight;
  std::uint64_t told_frames = 0;
  std::uint64_t told_slots = 0;
  live.robot.share(sight, [&](std::span<const std::uint32_t> slots) {
    ++told_frames;
    told_slots += slots.size();
  });
  live.robot.start();
  REQUIRE(live.becomes_true([&] { return live.place.driven_m() > 0.3; }));
  live.robot.stop();
  const mapper::FrameCounts frames = live.robot.frames();
  CHECK(frames.integrated > 0);
  CHECK(told_frames == frames.integrated);
  CHECK(sight.own_turns == frames.integrated);
  CHECK(sight.news_turns == frames.integrated);
  CHECK(told_slots > 0);
  CHECK(sight.shown == &live.robot.mapper().map());
  CHECK(live.robot.navigator().ground().states().cells.size() > 0);
}
