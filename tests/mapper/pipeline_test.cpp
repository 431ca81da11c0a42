// SPDX-License-Identifier: Apache-2.0
// The pipeline against a scripted camera and scripted poses: order, accounting of every kind of bad frame, stopping.
#include "mapper/pipeline.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <thread>
#include <vector>

using namespace g3d;
using hal::DropReason;

namespace {

constexpr hal::TimeNs kFrame_ns = 33'000'000;

struct Scripted {
  hal::TimeNs stamp_ns = 0;
  std::optional<DropReason> dropped;
};

/// A wall 1.5 m ahead in every frame.
class ScriptedCamera final : public hal::DepthCamera {
 public:
  explicit ScriptedCamera(std::vector<Scripted> script) : script_(std::move(script)) {
    model_ = {.width_px = 32, .height_px = 24, .fx_px = 26, .fy_px = 26, .cx_px = 15.5F, .cy_px = 11.5F};
  }
  const hal::CameraModel& model() const override { return model_; }
  hal::CameraRead read(hal::Frame& out) override {
    if (next_ == script_.size()) return {hal::CameraEvent::end, {}};
    const Scripted& now = script_[next_++];
    if (before_read) before_read(next_);
    if (now.dropped) return {hal::CameraEvent::dropped, *now.dropped};
    out.stamp_ns = now.stamp_ns;
    out.sequence = next_;
    out.has_colour = false;
    std::fill_n(out.depth.get(), model_.pixel_count(), std::uint16_t{1500});
    return {hal::CameraEvent::frame, {}};
  }
  std::function<void(std::size_t)> before_read;

 private:
  hal::CameraModel model_;
  std::vector<Scripted> script_;
  std::size_t next_ = 0;
};

/// The camera creeps forward; `special` stamps have another answer.
class ScriptedPoses final : public hal::PoseSource {
 public:
  hal::PoseStatus pose_at(hal::TimeNs stamp_ns, hal::Pose& pose) const override {
    pose = hal::from_xyz_rpy(static_cast<double>(stamp_ns) * 1e-11, 0, 1, -1.57, 0, -1.57);
    const auto it = special.find(stamp_ns);
    if (it == special.end()) return hal::PoseStatus::ok;
    if (it->second == DropReason::no_pose) return hal::PoseStatus::not_known;
    if (it->second == DropReason::out_of_range) pose.translation_m[0] = 1e6;
    if (it->second == DropReason::bad_pose) pose.rotation_xyzw[2] = std::numeric_limits<double>::quiet_NaN();
    return hal::PoseStatus::ok;
  }
  std::map<hal::TimeNs, DropReason> special;
};

class RecordingSink final : public mapper::FrameSink {
 public:
  void on_frame(const mapper::MappedFrame& frame) override {
    stamps_ns.push_back(frame.stamp_ns);
    if (delay.count() > 0) std::this_thread::sleep_for(delay);
  }
  void on_progress(const mapper::Progress& progress) override { last = progress; }
  std::vector<hal::TimeNs> stamps_ns;
  std::chrono::milliseconds delay{0};
  mapper::Progress last;
};

std::vector<Scripted> regular(int count) {
  std::vector<Scripted> script;
  for (int i = 1; i <= count; ++i) script.push_back({i * kFrame_ns, std::nullopt});
  return script;
}

mapper::MapperConfig small_map() {
  mapper::MapperConfig config;
  config.resolution_m = 0.1F;
  config.capacity = {.blocks = 4096, .planes = 4096, .colour_bricks = 64};
  return config;
}

struct Rig {
  explicit Rig(std::vector<Scripted> script, mapper::PipelineConfig config = {})
      : camera(std::move(script)),
        mapper(small_map(), camera.model()),
        pipeline(camera, poses, mapper, sink, clock, config) {}
  std::uint64_t dropped(DropReason reason) const { return pipeline.frames().dropped[static_cast<std::size_t>(reason)]; }
  ScriptedCamera camera;
  ScriptedPoses poses;
  RecordingSink sink;
  hal::RealClock clock;
  mapper::Mapper mapper;
  mapper::Pipeline pipeline;
};

}  // namespace

TEST_CASE("lockstep integrates every frame, in order", "[mapper][pipeline][threads]") {
  Rig rig(regular(100));
  rig.pipeline.run();
  CHECK(rig.pipeline.frames().delivered == 100);
  CHECK(rig.pipeline.frames().integrated == 100);
  CHECK(rig.pipeline.frames().balanced());
  REQUIRE(rig.sink.stamps_ns.size() == 100);
  CHECK(std::is_sorted(rig.sink.stamps_ns.begin(), rig.sink.stamps_ns.end()));
  CHECK(rig.sink.last.integrated == 100);
  CHECK(rig.mapper.map().counts().occupied > 0);
  CHECK_FALSE(rig.pipeline.was_interrupted());
  for (const auto stage : {mapper::Stage::pose, mapper::Stage::integrate, mapper::Stage::end_to_end}) {
    CHECK(rig.pipeline.times(stage).count() == 100);
  }
}

TEST_CASE("a camera without frames ends the run", "[mapper][pipeline][threads]") {
  Rig rig({});
  rig.pipeline.run();
  CHECK(rig.pipeline.frames().delivered == 0);
  CHECK(rig.pipeline.frames().balanced());
  CHECK(rig.mapper.map().counts().known() == 0);
}

TEST_CASE("every kind of bad frame is counted under its reason", "[mapper][pipeline][threads]") {
  std::vector<Scripted> script = regular(20);
  script[1].dropped = DropReason::unreadable_depth;
  script[2].dropped = DropReason::unreadable_depth;
  script[4].dropped = DropReason::wrong_size;
  script[6].stamp_ns = script[5].stamp_ns;  // not later than the one before
  script[7].stamp_ns = 1;
  Rig rig(script);
  rig.poses.special = {{script[9].stamp_ns, DropReason::no_pose},
                       {script[10].stamp_ns, DropReason::bad_pose},
                       {script[11].stamp_ns, DropReason::bad_pose},
                       {script[13].stamp_ns, DropReason::out_of_range}};
  rig.pipeline.run();
  CHECK(rig.dropped(DropReason::unreadable_depth) == 2);
  CHECK(rig.dropped(DropReason::wrong_size) == 1);
  CHECK(rig.dropped(DropReason::time_backwards) == 2);
  CHECK(rig.dropped(DropReason::no_pose) == 1);
  CHECK(rig.dropped(DropReason::bad_pose) == 2);
  CHECK(rig.dropped(DropReason::out_of_range) == 1);
  CHECK(rig.pipeline.frames().delivered == 20);
  CHECK(rig.pipeline.frames().integrated == 11);
  CHECK(rig.pipeline.frames().balanced());
  CHECK(rig.sink.stamps_ns.size() == 11);
}

TEST_CASE("one stamp from the far future does not condemn the frames after it", "[mapper][pipeline][threads]") {
  std::vector<Scripted> script = regular(10);
  script[3].stamp_ns = std::numeric_limits<hal::TimeNs>::max() / 2;
  Rig rig(script);
  rig.poses.special = {{script[3].stamp_ns, DropReason::no_pose}};
  rig.pipeline.run();
  CHECK(rig.pipeline.frames().integrated == 9);
  CHECK(rig.dropped(DropReason::no_pose) == 1);
}

TEST_CASE("the robot's place is free where its first frame puts it", "[mapper][pipeline][threads]") {
  // The camera, 1 m up, stands 0.2 m ahead of the base's centre; turned like the poses, so only the shift remains.
  const hal::Pose T_base_camera = hal::from_xyz_rpy(0.2, 0, 1, -1.57, 0, -1.57);
  Rig rig(regular(20), {.footprint = mapper::StartFootprint{0.25, 0.5, T_base_camera}});
  rig.pipeline.run();
  const mapper::VoxelMap& map = rig.mapper.map();
  const auto state = [&](float x, float y, float z) {
    const auto index = [&](float metres) { return map.grid().to_index(metres); };
    return mapper::state_of(map.at(mapper::VoxelIndex{index(x), index(y), index(z)}));
  };
  CHECK(state(-0.2F, 0.0F, 0.25F) == mapper::State::free);
  CHECK(state(-0.4F, 0.0F, 0.25F) == mapper::State::free);
  CHECK(state(-0.2F, 0.2F, 0.45F) == mapper::State::free);
  CHECK(state(-0.65F, 0.0F, 0.25F) == mapper::State::unknown);
  CHECK(state(0.25F, 0.0F, 0.25F) == mapper::State::unknown);
  CHECK(state(-0.2F, 0.0F, 0.75F) == mapper::State::unknown);
  Rig without(regular(20));
  without.pipeline.run();
  CHECK(rig.mapper.map().counts().free > without.mapper.map().counts().free);
}

TEST_CASE("a stop request finishes what is under way and counts it", "[mapper][pipeline][threads]") {
  Rig rig(regular(1000));
  rig.camera.before_read = [&](std::size_t n) {
    if (n == 50) rig.pipeline.request_stop();
  };
  rig.pipeline.run();
  CHECK(rig.pipeline.was_interrupted());
  CHECK(rig.pipeline.frames().delivered == 50);
  CHECK(rig.pipeline.frames().integrated == 50);
  CHECK(rig.pipeline.frames().balanced());
}

TEST_CASE("a stop request does not wait for a frame that is due later", "[mapper][pipeline][threads]") {
  std::vector<Scripted> script = regular(2);
  script[1].stamp_ns = script[0].stamp_ns + 4'000'000'000;
  Rig rig(script, {.rate = 1.0});
  const auto start = std::chrono::steady_clock::now();
  std::thread impatient([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    rig.pipeline.request_stop();
  });
  rig.pipeline.run();
  impatient.join();
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(2));
  CHECK(rig.dropped(DropReason::interrupted) == 1);
  CHECK(rig.pipeline.frames().balanced());
}

TEST_CASE("real time releases frames at their stamps", "[mapper][pipeline][threads]") {
  Rig rig(regular(7), {.rate = 2.0});
  const auto start = std::chrono::steady_clock::now();
  rig.pipeline.run();
  const auto took = std::chrono::steady_clock::now() - start;
  CHECK(took >= std::chrono::nanoseconds(3 * kFrame_ns));  // six periods at twice the speed
  CHECK(took < std::chrono::seconds(3));
  CHECK(rig.pipeline.frames().integrated == 7);
}

TEST_CASE("real time drops what it cannot keep up with, and counts it", "[mapper][pipeline][threads]") {
  Rig rig(regular(400), {.rate = 1e9, .frames_under_way = 2});
  rig.sink.delay = std::chrono::milliseconds(1);
  rig.pipeline.run();
  CHECK(rig.dropped(DropReason::queue_full) > 0);
  CHECK(rig.pipeline.frames().delivered == 400);
  CHECK(rig.pipeline.frames().balanced());
  CHECK(rig.sink.stamps_ns.size() == rig.pipeline.frames().integrated);
}

TEST_CASE("random faults never lose a frame from the books", "[mapper][pipeline][threads]") {
  std::mt19937 random(11);
  for (int round = 0; round < 8; ++round) {
    std::vector<Scripted> script = regular(60);
    std::map<hal::TimeNs, DropReason> special;
    for (Scripted& frame : script) {
      const auto fault = random() % 10;
      if (fault == 0) frame.dropped = DropReason::unreadable_depth;
      if (fault == 1) frame.stamp_ns -= 3 * kFrame_ns;
      if (fault == 2) special[frame.stamp_ns] = DropReason::bad_pose;
      if (fault == 3) special[frame.stamp_ns] = DropReason::no_pose;
      if (fault == 4) special[frame.stamp_ns] = DropReason::out_of_range;
    }
    Rig rig(script, {.rate = round % 2 == 0 ? 0.0 : 1e7, .frames_under_way = 1 + round % 3});
    rig.poses.special = special;
    rig.pipeline.run();
    CHECK(rig.pipeline.frames().delivered == 60);
    CHECK(rig.pipeline.frames().balanced());
    CHECK(rig.pipeline.frames().integrated == rig.sink.stamps_ns.size());
  }
}
