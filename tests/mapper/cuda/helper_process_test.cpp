// SPDX-License-Identifier: Apache-2.0
// The helper process with a driver that has no card behind it: same map, and what happens when it dies or hangs.
#include "mapper/cuda/helper_process.hpp"

#include <signal.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <map>
#include <vector>

#include "mapper/cpu/bulk_rays.hpp"
#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/twin.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/fake_card.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;
using cuda::HelperCommand;
using cuda::HelperProcess;
using cuda::HelperState;

namespace {

constexpr hal::TimeNs kSecond_ns = 1'000'000'000;

MapperConfig small_config() {
  MapperConfig config;
  config.resolution_m = 0.08F;
  config.capacity = {1U << 13, 1U << 12, 1U << 13};
  return config;
}

struct Rig {
  explicit Rig(const hal::CameraModel& camera)
      : sensor(camera, config.resolution_m, config.near_m, config.far_m),
        map(Grid{config.resolution_m}, config.capacity),
        twin(config, sensor, {}, map) {
    std::string problem;
    helper = HelperProcess::start({.program = cuda::carried_helper(),
                                   .kernels = cuda::carried_kernels(),
                                   .sizes = twin.builder().sizes(),
                                   .room = 64,
                                   .column_slope = sensor.column_slope,
                                   .row_slope = sensor.row_slope,
                                   .mask = twin.builder().mask(),
                                   .patience_ns = 30 * kSecond_ns},  // the driver here is slow
                                  problem);
    REQUIRE(problem == "");
    REQUIRE(helper != nullptr);
  }
  bool integrate(const hal::Frame& frame, const hal::Pose& pose, FrameReport& report) {
    return twin.integrate(frame, *cpu::frame_geometry(sensor, hal::to_transform(pose)), true, ++frame_number, report);
  }
  MapperConfig config = small_config();
  cpu::SensorGeometry sensor;
  VoxelMap map;
  cuda::Twin twin;
  std::shared_ptr<HelperProcess> helper;
  std::uint32_t frame_number = 0;
};

}  // namespace

TEST_CASE("frames through the helper process give the CPU twin's map, with and without mapped memory") {
  const hal::CameraModel camera = test::small_camera(60);
  const auto frames = test::random_frames(camera, 3, 40);
  for (const bool can_map : {true, false}) {
    const test::FakeCard card(test::FakeDriver::works);
    if (!can_map) setenv("FAKE_CUDA_CANNOT_MAP", "1", 1);
    Rig rig(camera);
    REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
    CHECK(rig.helper->card_name() == "a card that is none");
    rig.twin.set_card(rig.helper);
    Mapper cpu_twin(small_config(), camera);
    for (const auto& [frame, pose] : frames) {
      FrameReport report;
      REQUIRE(rig.integrate(frame, pose, report));
      CHECK(report.valid_pixels == cpu_twin.integrate(frame, pose).valid_pixels);
      REQUIRE(map_hash(rig.map) == map_hash(cpu_twin.map()));
      REQUIRE(rig.map.erase_block(rig.map.sorted_keys()[0]));
      REQUIRE(cpu_twin.map().erase_block(cpu_twin.map().sorted_keys()[0]));
    }
  }
}

TEST_CASE("questions through the helper process are answered as by the CPU twin, in one round or several") {
  const hal::CameraModel camera = test::small_camera(40);
  for (const bool can_map : {true, false}) {
    const test::FakeCard card(test::FakeDriver::works);
    if (!can_map) setenv("FAKE_CUDA_CANNOT_MAP", "1", 1);
    Rig rig(camera);
    REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
    rig.twin.set_card(rig.helper);
    for (const auto& [frame, pose] : test::random_frames(camera, 2, 44)) {
      FrameReport report;
      REQUIRE(rig.integrate(frame, pose, report));
    }
    cpu::ThreadPool pool(1);
    const std::vector<BulkRay> rays = test::random_rays(45, 5000, rig.config.resolution_m, 3.0);
    std::vector<BulkHit> expected(rays.size());
    std::vector<BulkHit> hits(rays.size());
    cpu::cast_bulk_rays(rig.map, rays, expected, pool);
    REQUIRE(rig.twin.cast_rays(rays, hits));
    CHECK(test::same_hits(hits, expected));
    const LookModel model = cpu::look_model(rig.sensor, 2);
    std::vector<Look> looks;
    for (std::uint64_t i = 0; i < rig.helper->look_room() + 3; ++i) {
      looks.push_back(cpu::look_from(rig.sensor, hal::to_transform(test::random_pose(i))));
    }
    std::vector<Look> expected_looks = looks;
    cpu::LookCounter(rig.sensor).count(rig.map, model, expected_looks, pool);
    REQUIRE(rig.twin.count_looks(model, looks));
    CHECK(std::memcmp(looks.data(), expected_looks.data(), looks.size() * sizeof(Look)) == 0);
  }
}

TEST_CASE("columns of what a frame changed come through the helper process as from an emulated card") {
  const hal::CameraModel camera = test::small_camera(60);
  ColumnTables tables{};
  tables.first_block_z = 4096 - 10;
  tables.last_block_z = 4096 + 10;
  tables.voxels_per_cell = 1;
  for (int z = 0; z < 21; ++z) {
    for (int i = 0; i < 8; ++i) tables.kinds[z][i] = static_cast<std::uint8_t>((z + i) % kLayerKinds);
  }
  for (std::uint32_t kind = 0; kind < kLayerKinds; ++kind) {
    for (std::uint32_t level = 0; level < kColumnLevels; ++level) {
      tables.bits[kind][level] = static_cast<std::uint8_t>((kind * 7 + level) & 63U);
    }
  }
  for (const bool can_map : {true, false}) {
    const test::FakeCard card(test::FakeDriver::works);
    if (!can_map) setenv("FAKE_CUDA_CANNOT_MAP", "1", 1);
    Rig rig(camera);
    REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
    rig.twin.set_card(rig.helper);
    test::EmulatedMapper emulated(small_config(), camera, 3);
    rig.twin.follow_columns(tables);
    emulated.twin.follow_columns(tables);
    for (const auto& [frame, pose] : test::random_frames(camera, 3, 46)) {
      FrameReport report;
      REQUIRE(rig.integrate(frame, pose, report));
      (void)emulated.integrate(frame, pose);
      const auto by_key = [](const ChangedColumns& columns) {
        std::map<BlockKey, std::vector<std::uint8_t>> cells;
        for (std::size_t i = 0; i < columns.keys.size(); ++i) {
          const std::uint8_t* first = columns.cells + i * columns.cells_per_block;
          cells[columns.keys[i]].assign(first, first + columns.cells_per_block);
        }
        return cells;
      };
      CHECK_FALSE(rig.twin.changed_columns().keys.empty());
      CHECK(by_key(rig.twin.changed_columns()) == by_key(emulated.twin.changed_columns()));
    }
  }
}

TEST_CASE("measuring commands give the same map") {
  const hal::CameraModel camera = test::small_camera(60);
  const test::FakeCard card(test::FakeDriver::works);
  Rig rig(camera);
  REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
  rig.twin.set_card(rig.helper);
  Mapper cpu_twin(small_config(), camera);
  for (const auto& [frame, pose] : test::random_frames(camera, 2, 41)) {
    rig.helper->set_frame_command(rig.frame_number == 0 ? HelperCommand::run_frame_timed
                                                        : HelperCommand::run_stages_timed);
    FrameReport report;
    REQUIRE(rig.integrate(frame, pose, report));
    (void)cpu_twin.integrate(frame, pose);
    CHECK(map_hash(rig.map) == map_hash(cpu_twin.map()));
  }
}

TEST_CASE("a helper that is killed is noticed at once, before and during a command") {
  const hal::CameraModel camera = test::small_camera(60);
  const test::FakeCard card(test::FakeDriver::works);
  hal::RealClock clock;
  {
    Rig rig(camera);
    REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
    REQUIRE(kill(rig.helper->pid(), SIGKILL) == 0);
    const hal::TimeNs start_ns = clock.now();
    CHECK_FALSE(rig.helper->ask(HelperCommand::send_blocks, 0, 20 * kSecond_ns));
    CHECK(clock.now() - start_ns < 10 * kSecond_ns);
    CHECK(rig.helper->state() == HelperState::failed);
    CHECK(rig.helper->problem() == "the helper process ended");
    CHECK_FALSE(rig.helper->ask(HelperCommand::send_blocks, 0, 20 * kSecond_ns));
  }
  Rig rig(camera);
  REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
  REQUIRE(kill(rig.helper->pid(), SIGSTOP) == 0);  // a driver that hangs
  CHECK_FALSE(rig.helper->ask(HelperCommand::send_blocks, 0, kSecond_ns / 10));
  CHECK(rig.helper->problem() == "the helper process does not answer");
}

TEST_CASE("a helper that hangs is given up after the time allowed") {
  const hal::CameraModel camera = test::small_camera(60);
  const test::FakeCard card(test::FakeDriver::works);
  Rig rig(camera);
  REQUIRE(rig.helper->wait_started(20 * kSecond_ns) == HelperState::ready);
  CHECK_FALSE(rig.helper->ask(HelperCommand::hang, 0, kSecond_ns / 20));
  const pid_t pid = rig.helper->pid();
  rig.helper.reset();
  CHECK(kill(pid, 0) != 0);  // it is gone, and has been waited for
}

TEST_CASE("a build without kernels says so") {
  std::string problem;
  CHECK(HelperProcess::start({}, problem) == nullptr);
  CHECK(problem.find("clang") != std::string::npos);
}
