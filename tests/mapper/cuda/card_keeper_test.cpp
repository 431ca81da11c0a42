// SPDX-License-Identifier: Apache-2.0
// A mapper with a card that comes and goes: no frame is lost or counted twice, and the map is the undisturbed one.
#include "mapper/cuda/card_keeper.hpp"

#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <thread>

#include "mapper/map_hash.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/fake_card.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

MapperConfig config_on(Backend backend) {
  MapperConfig config;
  config.resolution_m = 0.11F;
  config.capacity = {1U << 12, 1U << 11, 1U << 12};
  config.backend = backend;
  config.card_patience_ns = 3'000'000'000;  // this card is slow
  return config;
}

/// A pose of its own for each frame would leave nothing to integrate twice.
std::vector<test::PosedImage> frames_of(const hal::CameraModel& camera, int count) {
  return test::random_frames(camera, count, 50);
}

}  // namespace

TEST_CASE("without a driver the CPU does all, and says why") {
  const test::FakeCard card(test::FakeDriver::not_there);
  const hal::CameraModel camera = test::small_camera(40);
  Mapper plain(config_on(Backend::cpu), camera);
  Mapper mapper(config_on(Backend::automatic), camera);
  CHECK(std::string(mapper.backend_name()) == "cpu");
  CHECK(mapper.card().name == "");
  CHECK(mapper.card().problem.find("no NVIDIA driver") != std::string::npos);
  for (const auto& [frame, pose] : frames_of(camera, 3)) {
    (void)plain.integrate(frame, pose);
    (void)mapper.integrate(frame, pose);
  }
  CHECK(mapper.card().frames_on_cpu == 3);
  CHECK(mapper.card().losses == 0);
  CHECK(map_hash(mapper.map()) == map_hash(plain.map()));
}

TEST_CASE("a card that is lost again and again costs no frame and no voxel") {
  const test::FakeCard card(test::FakeDriver::works);
  const hal::CameraModel camera = test::small_camera(40);
  Mapper plain(config_on(Backend::cpu), camera);
  Mapper mapper(config_on(Backend::cuda), camera);
  REQUIRE(std::string(mapper.backend_name()) == "cuda");
  const auto frames = frames_of(camera, 24);
  std::uint64_t integrated = 0;
  std::uint32_t kills = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool kill_now = i % 4 == 2 && mapper.card_process() > 0;
    if (kill_now) {
      REQUIRE(kill(mapper.card_process(), i % 8 == 2 ? SIGKILL : SIGSTOP) == 0);
      ++kills;
    }
    const FrameReport expected = plain.integrate(frames[i].frame, frames[i].T_world_camera);
    const FrameReport report = mapper.integrate(frames[i].frame, frames[i].T_world_camera);
    CHECK(report.valid_pixels == expected.valid_pixels);
    CHECK(report.hit_blocks == expected.hit_blocks);
    ++integrated;
    REQUIRE(map_hash(mapper.map()) == map_hash(plain.map()));
    CHECK(mapper.changed_slots().size() == plain.changed_slots().size());
    CHECK(mapper.card().frames_on_card + mapper.card().frames_on_cpu == integrated);
  }
  CHECK(kills > 0);
  CHECK(mapper.card().losses > 0);
  CHECK(mapper.card().frames_on_card > 0);
}

TEST_CASE("a helper that dies while it comes up again is not the last one") {
  const test::FakeCard card(test::FakeDriver::works);
  const hal::CameraModel camera = test::small_camera(40);
  Mapper plain(config_on(Backend::cpu), camera);
  Mapper mapper(config_on(Backend::cuda), camera);
  const auto frames = frames_of(camera, 200);
  std::size_t next = 0;
  const auto integrate_one = [&] {
    REQUIRE(next < frames.size());
    (void)plain.integrate(frames[next].frame, frames[next].T_world_camera);
    (void)mapper.integrate(frames[next].frame, frames[next].T_world_camera);
    ++next;
  };
  integrate_one();
  for (int times = 0; times < 3; ++times) {  // the first one while it works, the others before they do
    const std::uint64_t by_card = mapper.card().frames_on_card;
    const int process = mapper.card_process();
    REQUIRE(process > 0);
    REQUIRE(kill(process, SIGKILL) == 0);
    while (mapper.card_process() == process || mapper.card_process() <= 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      integrate_one();
    }
    CHECK(mapper.card().frames_on_card == by_card);
  }
  const std::uint64_t by_card = mapper.card().frames_on_card;
  while (mapper.card().frames_on_card == by_card) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    integrate_one();
  }
  CHECK(map_hash(mapper.map()) == map_hash(plain.map()));
}

TEST_CASE("questions are answered alike by the card, without one, and when it is lost over them") {
  const test::FakeCard card(test::FakeDriver::works);
  const hal::CameraModel camera = test::small_camera(40);
  Mapper plain(config_on(Backend::cpu), camera);
  Mapper mapper(config_on(Backend::cuda), camera);
  const auto frames = frames_of(camera, 3);
  const std::vector<BulkRay> rays = test::random_rays(7, 900, 0.11F, 4.0);
  const auto check_equal = [&] {
    std::vector<BulkHit> expected(rays.size());
    std::vector<BulkHit> hits(rays.size());
    plain.cast_rays(rays, expected);
    mapper.cast_rays(rays, hits);
    CHECK(test::same_hits(hits, expected));
    std::vector<Look> looks{plain.look_from(test::random_pose(1)), plain.look_from(test::random_pose(2))};
    std::vector<Look> expected_looks = looks;
    plain.count_looks(expected_looks, 2);
    mapper.count_looks(looks, 2);
    CHECK(std::memcmp(looks.data(), expected_looks.data(), looks.size() * sizeof(Look)) == 0);
    CHECK(looks[0].gain.unknown_voxels > 0);
  };
  for (std::size_t i = 0; i < 2; ++i) {
    (void)plain.integrate(frames[i].frame, frames[i].T_world_camera);
    (void)mapper.integrate(frames[i].frame, frames[i].T_world_camera);
    check_equal();
  }
  CHECK(mapper.card().questions_on_card == 4);
  // Between the two parts of a frame the card's map is not yet what map() says.
  REQUIRE(mapper.begin_frame(frames[2].frame, frames[2].T_world_camera));
  check_equal();
  CHECK(mapper.card().questions_on_card == 4);
  (void)mapper.finish_frame();
  (void)plain.integrate(frames[2].frame, frames[2].T_world_camera);
  REQUIRE(kill(mapper.card_process(), SIGKILL) == 0);
  check_equal();
  CHECK(mapper.card().questions_on_cpu == 2);
  CHECK(mapper.card().losses == 1);
  CHECK(map_hash(mapper.map()) == map_hash(plain.map()));
}

TEST_CASE("a footprint taken as free is in the card's map as well") {
  const test::FakeCard card(test::FakeDriver::works);
  const hal::CameraModel camera = test::small_camera(40);
  Mapper plain(config_on(Backend::cpu), camera);
  Mapper mapper(config_on(Backend::cuda), camera);
  for (Mapper* each : {&plain, &mapper}) each->free_footprint({0.5, 0.2, 0.0}, 0.4, 0.5);
  for (const auto& [frame, pose] : frames_of(camera, 3)) {
    (void)plain.integrate(frame, pose);
    (void)mapper.integrate(frame, pose);
    CHECK(map_hash(mapper.map()) == map_hash(plain.map()));
  }
}
