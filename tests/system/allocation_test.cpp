// SPDX-License-Identifier: Apache-2.0
// No thread of the pipeline allocates after the start. This program's malloc counts calls while it is armed, from every
// thread and out of every library.
#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <vector>

#include "hal/replay/recorded_poses.hpp"
#include "hal/replay/replay_camera.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/pose_drift.hpp"
#include "hal/sim/sim_camera.hpp"
#include "mapper/align/aligner.hpp"
#include "mapper/pipeline.hpp"
#include "mapper/rolling_window.hpp"
#include "mapper/run_sink.hpp"
#include "mapper/submaps/driving_loops.hpp"
#include "mapper/submaps/stretch_recorder.hpp"
#include "tests/support/corridor_walk.hpp"
#include "tests/support/log_folder.hpp"
#include "tests/support/looped_drive.hpp"
#include "tests/support/temp_folder.hpp"
#include "tests/system/counted_malloc.hpp"

namespace {
std::atomic<bool> armed{false};

void count_one() {
  if (g3d::test::this_thread_armed || armed.load(std::memory_order_relaxed)) {
    g3d::test::allocations.fetch_add(1, std::memory_order_relaxed);
  }
}
}  // namespace

namespace g3d::test {
std::atomic<std::uint64_t> allocations{0};
thread_local bool this_thread_armed = false;
}  // namespace g3d::test

extern "C" {
// glibc's own, under the names that remain when a program defines malloc itself.
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* old, std::size_t bytes);

void* malloc(std::size_t bytes) {
  count_one();
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
  count_one();
  return __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) {
  count_one();
  return __libc_realloc(old, bytes);
}
}

using namespace g3d;
using test::allocations;
using test::this_thread_armed;

namespace {

/// Arms the counter once the pipeline has started, and disarms it before the end.
class ArmingCamera final : public hal::DepthCamera {
 public:
  ArmingCamera(hal::DepthCamera& camera, std::size_t first, std::size_t last)
      : camera_(camera), first_(first), last_(last) {}
  const hal::CameraModel& model() const override { return camera_.model(); }
  hal::CameraRead read(hal::Frame& out) override {
    ++reads_;
    if (reads_ == first_) armed.store(true);
    if (reads_ == last_) armed.store(false);
    return camera_.read(out);
  }

 private:
  hal::DepthCamera& camera_;
  std::size_t first_, last_;
  std::size_t reads_ = 0;
};

/// How often anything was allocated between the reads `first` and `last`.
std::uint64_t count_allocations(hal::DepthCamera& camera, const hal::PoseSource& poses, std::size_t first,
                                std::size_t last, int threads, mapper::align::Aligner* aligner = nullptr) {
  const test::TempFolder folder;
  mapper::MapperConfig config;
  config.threads = threads;
  mapper::Mapper mapper(config, camera.model());
  auto trajectory = hal::TrajectoryWriter::create(folder / "trajectory.tum");
  REQUIRE(trajectory.ok());
  const hal::RealClock const_clock;
  hal::RealClock clock;
  mapper::ProgressBar bar(stderr, mapper::ProgressStyle::quiet, std::nullopt);
  mapper::RunSink sink(trajectory.value(), bar, const_clock);
  ArmingCamera arming(camera, first, last);
  mapper::Pipeline pipeline(arming, poses, mapper, sink, clock, {.aligner = aligner});
  allocations.store(0);
  pipeline.run();
  REQUIRE_FALSE(armed.load());
  REQUIRE(pipeline.frames().integrated >= last);
  REQUIRE(mapper.map().counts().occupied > 0);
  return allocations.load();
}

}  // namespace

TEST_CASE("the counter sees an allocation", "[system][allocation]") {
  allocations.store(0);
  armed.store(true);
  auto* volatile text = new std::string(100, 'x');
  armed.store(false);
  delete text;
  CHECK(allocations.load() >= 2);
}

TEST_CASE("mapping a simulated drive allocates nothing after the start", "[system][allocation]") {
  auto world = hal::load_world("furnished_room");
  auto path = hal::load_camera_path("furnished_room");
  REQUIRE(world.ok());
  REQUIRE(path.ok());
  hal::SimCameraOptions options;
  options.max_frames = 60;
  options.renderer.threads = 2;
  const hal::SimPoses poses(path.value());
  hal::SimCamera camera(std::move(world).value(), path.value(), options);
  CHECK(count_allocations(camera, poses, 3, 60, 2) == 0);
}

TEST_CASE("aligning a drifting drive allocates nothing after the start", "[system][allocation][align]") {
  auto world = hal::load_world("furnished_room");
  auto path = hal::load_camera_path("furnished_room");
  REQUIRE(world.ok());
  REQUIRE(path.ok());
  hal::SimCameraOptions options;
  options.max_frames = 30;
  options.renderer.threads = 2;
  std::vector<hal::StampedPose> truth;
  for (std::size_t i = 0; i < 30; ++i) {
    const hal::TimeNs stamp_ns = hal::frame_stamp_ns(path.value(), i, options.rate_hz);
    truth.push_back({stamp_ns, path.value().pose_at(stamp_ns)});
  }
  const hal::RecordedPoses poses(hal::drifted(truth, hal::robot_drift(1)));
  hal::SimCamera camera(std::move(world).value(), path.value(), options);
  mapper::align::Aligner aligner({}, camera.model());
  CHECK(count_allocations(camera, poses, 3, 30, 1, &aligner) == 0);
  CHECK(aligner.report().corrected() > 25);
}

TEST_CASE("submaps and loops allocate nothing in the thread that maps, moves of the map included",
          "[system][allocation]") {
  const test::DriveTwice twice = test::twice_through_a_room();
  const std::vector<hal::StampedPose> odometry = hal::drifted(twice.truth(), hal::robot_drift(3));
  mapper::Mapper mapper(test::looped_drive_config(), twice.work.camera);
  mapper::align::AlignOptions align;
  align.least_matched = 2.0;  // no frame ever matches so much: poses are odometry's, and there is something to correct
  mapper::align::Aligner aligner(align, twice.work.camera);
  mapper::submaps::DrivingOptions options;
  options.is_lockstep = true;
  options.answer_after_ns = 500'000'000;
  mapper::submaps::DrivingLoops loops(mapper.map(), twice.work.camera, options);
  int moved = 0;
  allocations.store(0);
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const hal::Frame& frame = twice.work.frames[i].frame;
    const mapper::align::AlignResult placed = aligner.align(frame, odometry[i].T_world_camera);
    (void)mapper.integrate(frame, placed.T_world_camera);
    this_thread_armed = true;
    loops.add(frame, placed, aligner.samples(), mapper.changed_slots());
    loops.wait_if_due(frame.stamp_ns);
    if (loops.begins_to_move(frame.stamp_ns)) ++moved;
    while (loops.is_moving()) {
      loops.wait_if_due(frame.stamp_ns);
      (void)loops.move_on();
    }
    this_thread_armed = false;
  }
  CHECK(moved > 0);
  CHECK(allocations.load() == 0);
}

TEST_CASE("mapping a recording with PNG images allocates nothing after the start", "[system][allocation]") {
  const test::TempFolder folder;
  test::write_log(folder.path(), {.frames = 30});
  auto camera = hal::ReplayCamera::open(folder.path());
  auto poses = hal::RecordedPoses::open(folder.path());
  REQUIRE(camera.ok());
  REQUIRE(poses.ok());
  CHECK(count_allocations(*camera.value(), *poses.value(), 3, 30, 1) == 0);
}

TEST_CASE("a rolling window allocates nothing in the mapper's thread", "[system][allocation][window]") {
  const bool lockstep = GENERATE(true, false);
  const test::TempFolder folder;
  const tests::CorridorWalk walk;
  mapper::MapperConfig config;
  mapper::Mapper mapper(config, walk.camera());
  auto file = mapper::create_page_file(folder.path());
  REQUIRE(file.ok());
  mapper::RollingWindow window(mapper, walk.camera(), {.radius_m = 0.0, .lockstep = lockstep}, std::move(file).value());
  hal::Frame frame = hal::make_frame(walk.camera());
  allocations.store(0);
  for (int i = 0; i < 700; ++i) {
    const hal::Pose pose = walk.pose(i);
    walk.draw(pose, frame);
    this_thread_armed = true;
    window.prepare(pose);
    (void)mapper.integrate(frame, pose);
    this_thread_armed = false;
  }
  CHECK(allocations.load() == 0);
  window.finish();
  CHECK(window.counts().regions_out > 10);
  CHECK(window.counts().regions_in > 10);
}

TEST_CASE("recording what becomes a submap allocates nothing, however many frames it has", "[system][allocation]") {
  mapper::VoxelMap view(mapper::Grid{}, {256, 256, 256});
  mapper::submaps::StretchRecorder recorder(view, {});
  mapper::submaps::Stretch stretch(view);
  const std::vector<mapper::align::DepthSample> samples(20, {{0.1F, 0.0F, 1.0F}, {0.0F, 0.0F, -1.0F}, 1.0F});
  mapper::BlockValues values;
  values.fill(20);
  std::vector<std::uint32_t> slots;
  for (int i = 0; i < 200; ++i) {
    const mapper::BlockKey key = mapper::block_of({32768 + 8 * i, 32768, 32768});
    REQUIRE(view.write_block(key, values));
    slots.push_back(view.find(key));
  }
  allocations.store(0);
  this_thread_armed = true;
  for (int i = 0; i < 20'000; ++i) {
    recorder.add_frame(i, hal::from_xyz_rpy(0.001 * i, 0, 0, 0, 0, 0), slots, samples, false);
  }
  const bool is_taken = recorder.take(stretch);
  stretch.clear();
  this_thread_armed = false;
  CHECK(is_taken);
  CHECK(allocations.load() == 0);
}
