// SPDX-License-Identifier: Apache-2.0
// No thread of the pipeline allocates after the start. This program's malloc counts calls while it is armed, from every
// thread and out of every library.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
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
#include "net/block_wire.hpp"
#include "net/fleet_radio.hpp"
#include "net/gossip.hpp"
#include "net/merged_map.hpp"
#include "net/pose_payload.hpp"
#include "net/udp_port.hpp"
#include "tests/support/corridor_walk.hpp"
#include "tests/support/gate_fleet.hpp"
#include "tests/support/log_folder.hpp"
#include "tests/support/looped_drive.hpp"
#include "tests/support/temp_folder.hpp"

namespace {
std::atomic<bool> armed{false};
std::atomic<std::uint64_t> allocations{0};

thread_local bool this_thread_armed = false;

void count_one() {
  if (this_thread_armed || armed.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
}
}  // namespace

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

namespace {

/// A robot as far as sharing goes, in real sockets.
struct SharingRobot {
  SharingRobot(const net::FleetKey& keys, std::uint64_t id, std::unique_ptr<net::UdpPort> its_port)
      : port(std::move(its_port)),
        gate(test::copy_of(keys), {.robot = id, .incarnation = 1}),
        radio(gate, *port),
        store({4, 1U << 10, 1U << 18}),
        gossip(options_of(id), store, radio) {}
  static net::GossipOptions options_of(std::uint64_t id) {
    net::GossipOptions options;
    options.self = {id, 1};
    options.seed = id;
    return options;
  }
  void step(hal::TimeNs now_ns) {
    (void)radio.receive(now_ns, [&](const net::Sender& sender, mapper::ByteSpan message) {
      gossip.on_message(sender, message, now_ns);
    });
    gossip.on_time(now_ns);
  }
  std::unique_ptr<net::UdpPort> port;
  net::DatagramGate gate;
  net::FleetRadio radio;
  net::LayerStore store;
  net::Gossip gossip;
};

/// Three robots whose messages go from hand to hand, one in eight is lost, and nothing of it allocates.
class AllocationFleet {
 public:
  static constexpr std::size_t kRobots = 3;
  AllocationFleet() {
    for (std::size_t i = 0; i < kRobots; ++i) robots_[i] = std::make_unique<Robot>(*this, i);
  }
  void publish(std::size_t i, std::uint64_t block, std::span<const std::uint8_t> payload) {
    (void)robots_[i]->gossip.publish(net::block_record(0, block, net::Part::whole), net::Lane::ground, payload);
    robots_[i]->gossip.commit(now_ns_);
  }
  void place(std::size_t i, const hal::Pose& T_world_submap) {
    const net::PosePayload payload = net::pose_payload(T_world_submap);
    (void)robots_[i]->gossip.publish(net::pose_record(0), net::Lane::ground, payload);
    robots_[i]->gossip.commit(now_ns_);
  }
  void step() {
    now_ns_ += 10'000'000;
    for (std::size_t to = 0; to < kRobots; ++to) {
      robots_[to]->gossip.on_time(now_ns_);
      robots_[to]->merged.update(robots_[to]->store);
    }
    for (std::size_t m = 0; m < count_; ++m) {
      const Message& message = messages_[m];
      for (std::size_t to = 0; to < kRobots; ++to) {
        if (to == message.from || (message.to != net::kEverybody && message.to != to + 1)) continue;
        if (++sent_ % 8 == 0) continue;
        robots_[to]->gossip.on_message({message.from + 1, 1, message.from + 1}, {message.bytes.data(), message.size},
                                       now_ns_);
      }
    }
    count_ = 0;
  }
  [[nodiscard]] std::size_t records(std::size_t i) const { return robots_[i]->store.record_count(); }
  [[nodiscard]] std::uint64_t merged_blocks(std::size_t i) const { return robots_[i]->merged.counts().merged_blocks; }

 private:
  struct Message {
    std::size_t from = 0;
    net::Address to = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, net::kMostMessage_bytes> bytes;
  };
  struct Robot final : net::Link {
    Robot(AllocationFleet& its_fleet, std::size_t its_number)
        : fleet(its_fleet),
          number(its_number),
          store({8, 4096, std::size_t{1} << 20, 512}),
          gossip(
              [&] {
                net::GossipOptions options;
                options.self = {its_number + 1, 1};
                options.seed = its_number;
                options.most_peers = kRobots;
                return options;
              }(),
              store, *this),
          merged({{0.05F}, {4096, 4096, 1024}, {1024, 1024, 256}, 4}) {}
    bool send(net::Address to, mapper::ByteSpan message) override {
      if (fleet.count_ == fleet.messages_.size()) return false;
      Message& place = fleet.messages_[fleet.count_++];
      place.from = number;
      place.to = to;
      place.size = message.size();
      std::copy(message.begin(), message.end(), place.bytes.begin());
      return true;
    }
    AllocationFleet& fleet;
    std::size_t number;
    net::LayerStore store;
    net::Gossip gossip;
    net::MergedMap merged;
  };
  std::vector<Message> messages_{400};
  std::size_t count_ = 0;
  std::uint64_t sent_ = 0;
  hal::TimeNs now_ns_ = 1'000'000'000;
  std::array<std::unique_ptr<Robot>, kRobots> robots_;
};

}  // namespace

TEST_CASE("sharing in real sockets allocates nothing once the robots know each other", "[system][allocation]") {
  const net::FleetKey keys = net::generate_fleet_key();
  net::UdpPortOptions options;
  options.interface = "lo";
  options.port = 0;
  options.group = "239.255.72." + std::to_string(1 + ::getpid() % 250);
  auto port_a = net::UdpPort::open(options), port_b = net::UdpPort::open(options);
  REQUIRE(port_a);
  REQUIRE(port_b);
  SharingRobot a(keys, 1, std::move(port_a).value()), b(keys, 2, std::move(port_b).value());
  hal::TimeNs now_ns = 0;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ns += 10 * hal::kMillisecond_ns;
      if (i % 20 == 0) {
        const std::uint8_t payload[2] = {static_cast<std::uint8_t>(i), 7};
        (void)a.gossip.publish(net::block_record(0, 100 + static_cast<std::uint64_t>(i), net::Part::whole),
                               net::Lane::ground, payload);
        a.gossip.commit(now_ns);
      }
      for (SharingRobot* robot : {&a, &b}) robot->step(now_ns);
    }
  };
  run(300);
  REQUIRE(b.gossip.members().all().size() == 1);
  const std::uint64_t before = b.radio.counts().delivered;
  allocations.store(0);
  this_thread_armed = true;
  run(2000);
  a.port->refresh();
  (void)b.port->wait(0);
  this_thread_armed = false;
  CHECK(allocations.load() == 0);
  CHECK(b.radio.counts().delivered > before + 100);
  run(100);
  CHECK(a.store.digest() == b.store.digest());
}

TEST_CASE("sharing and merging maps allocates nothing after the start, whoever is heard for the first time",
          "[system][allocation][net]") {
  AllocationFleet fleet;
  net::BlockPacker packer;
  mapper::BlockValues values{};
  values.fill(4);  // free
  std::vector<std::vector<std::uint8_t>> payloads;
  for (int i = 0; i < 8; ++i) {
    values[static_cast<std::size_t>(i * 60)] = 28;  // occupied
    for (const net::PackedPart& part : packer.pack_within(values, net::kMostPayload_bytes)) {
      if (part.part == net::Part::whole) payloads.emplace_back(part.bytes.begin(), part.bytes.end());
    }
  }
  REQUIRE(payloads.size() == 8);
  const mapper::BlockKey corner = mapper::block_of({32768, 32768, 32768});
  allocations.store(0);
  this_thread_armed = true;
  for (int i = 0; i < 300; ++i) {
    const auto robot = static_cast<std::size_t>(i % 3);
    fleet.publish(robot, corner + static_cast<std::uint64_t>(i % 40), payloads[static_cast<std::size_t>(i % 8)]);
    if (i % 50 < 3) fleet.place(robot, hal::Pose{{0.01 * i, 0.0, 0.0}});
    fleet.step();
  }
  for (int i = 0; i < 300; ++i) fleet.step();
  this_thread_armed = false;
  CHECK(allocations.load() == 0);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(fleet.records(i) > 100);
    CHECK(fleet.records(i) == fleet.records(0));
    CHECK(fleet.merged_blocks(i) > 100);
  }
}
