// SPDX-License-Identifier: Apache-2.0
// The card's map and its mirror stay equal, whoever changes which of them; and a card that lies or fails changes
// nothing.
#include "mapper/cuda/twin.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

#include "mapper/cpu/bulk_rays.hpp"
#include "mapper/map_hash.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/faulty_card.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

MapperConfig small_config() {
  MapperConfig config;
  config.capacity = {1U << 14, 1U << 13, 1U << 14};
  return config;
}

/// Forgets some blocks and fills others, as paging and merging do; the same in every map.
void change_blocks(VoxelMap& map, std::uint64_t seed) {
  tests::Random random(seed);
  BlockValues values;
  for (const BlockKey key : map.sorted_keys()) {
    const std::uint32_t fate = random.below(12);
    if (fate == 0) map.erase_block(key);
    if (fate != 1) continue;
    map.read_stored_block(key, values);
    values[random.below(512)] = make_rgbo(1, 2, 3, 20) | kHasColourBit;
    values[random.below(512)] = 5;
    REQUIRE(map.write_block(key, values));
    REQUIRE(map.write_block(key, values));  // twice between two frames: it is sent once
  }
}

}  // namespace

TEST_CASE("what the host changes between frames is in the card before the next one") {
  const hal::CameraModel camera = test::small_camera(80);
  Mapper cpu_twin(small_config(), camera);
  test::EmulatedMapper emulated(small_config(), camera, 5);
  std::uint64_t seed = 0;
  for (const auto& [frame, pose] : test::random_frames(camera, 8, 5)) {
    (void)cpu_twin.integrate(frame, pose);
    (void)emulated.integrate(frame, pose);
    REQUIRE(map_hash(emulated.map) == map_hash(cpu_twin.map()));
    change_blocks(emulated.map, ++seed);
    change_blocks(cpu_twin.map(), seed);
  }
}

TEST_CASE("a new card goes on with the map of the mirror") {
  const hal::CameraModel camera = test::small_camera(80);
  Mapper cpu_twin(small_config(), camera);
  test::EmulatedMapper emulated(small_config(), camera, 6);
  for (const auto& [frame, pose] : test::random_frames(camera, 6, 6)) {
    (void)cpu_twin.integrate(frame, pose);
    (void)emulated.integrate(frame, pose);
    REQUIRE(map_hash(emulated.map) == map_hash(cpu_twin.map()));
    emulated.new_card(100 + emulated.frame_number);
  }
}

TEST_CASE("a frame that changes more blocks than there is room for comes in rounds, and is whole or not at all") {
  const hal::CameraModel camera = test::small_camera(100);
  MapperConfig config = small_config();
  config.resolution_m = 0.02F;
  config.capacity = {1U << 16, 1U << 15, 1U << 16};
  Mapper cpu_twin(config, camera);
  test::EmulatedMapper emulated(config, camera, 7);
  auto faulty = std::make_shared<test::FaultyCard>(emulated.card);
  emulated.twin.set_card(faulty);
  const auto frames = test::random_frames(camera, 3, 7);
  for (const auto& [frame, pose] : frames) {
    (void)cpu_twin.integrate(frame, pose);
    (void)emulated.integrate(frame, pose);
    REQUIRE(emulated.twin.changed_slots().size() > emulated.card->room());
    REQUIRE(map_hash(emulated.map) == map_hash(cpu_twin.map()));
  }
  faulty->fails_to_send = true;
  FrameReport report;
  const auto geometry = cpu::frame_geometry(emulated.sensor, hal::to_transform(frames[0].T_world_camera));
  CHECK_FALSE(emulated.twin.integrate(frames[0].frame, *geometry, true, 9, report));
  CHECK(map_hash(emulated.map) == map_hash(cpu_twin.map()));
}

TEST_CASE("a card that fails or lies is lost, and the mirror is what it was") {
  const hal::CameraModel camera = test::small_camera(60);
  const auto frames = test::random_frames(camera, 2, 8);
  using Lie = std::function<void(test::FaultyCard&)>;
  const auto about_frame = [](auto spoil) { return [spoil](test::FaultyCard& card) { card.spoil = spoil; }; };
  const auto about_parcels = [](auto spoil) { return [spoil](test::FaultyCard& card) { card.spoil_parcels = spoil; }; };
  const std::vector<Lie> lies{
      about_frame([](cuda::FrameCounters& c, const cuda::Classes&) { c.changed = 0xFFFFFFFF; }),
      about_frame([](cuda::FrameCounters& c, const cuda::Classes&) { c.refused_imports = 1; }),
      about_frame([](cuda::FrameCounters&, const cuda::Classes& p) { p.heads[1].key = ~std::uint64_t{0}; }),
      about_frame([](cuda::FrameCounters&, const cuda::Classes& p) { p.heads[0].uniform = 3; }),
      about_parcels([](const cuda::Parcels& p) { p.heads[3].plane = 1U << 30; }),
      about_parcels([](const cuda::Parcels& p) { p.heads[0].first_brick = 77777; }),
      about_parcels([](const cuda::Parcels& p) { p.heads[1].key = ~std::uint64_t{0}; }),
      about_parcels([](const cuda::Parcels& p) { p.heads[2].uniform_level = 77; }),
  };
  for (std::size_t fault = 0; fault < lies.size() + 2; ++fault) {
    INFO("fault " << fault);
    test::EmulatedMapper emulated(small_config(), camera, 8);
    auto faulty = std::make_shared<test::FaultyCard>(emulated.card);
    emulated.twin.set_card(faulty);
    (void)emulated.integrate(frames[0].frame, frames[0].T_world_camera);
    const std::string before = map_hash(emulated.map);
    if (fault < lies.size()) lies[fault](*faulty);
    faulty->fails_to_run = fault == lies.size();
    faulty->fails_to_import = fault == lies.size() + 1;
    if (faulty->fails_to_import) {
      emulated.map.erase_block(emulated.map.sorted_keys()[0]);
      emulated.map.erase_block(emulated.map.sorted_keys()[0]);
    }
    const std::string expected = faulty->fails_to_import ? map_hash(emulated.map) : before;
    FrameReport report;
    const auto geometry = cpu::frame_geometry(emulated.sensor, hal::to_transform(frames[1].T_world_camera));
    REQUIRE(geometry);
    CHECK_FALSE(emulated.twin.integrate(frames[1].frame, *geometry, true, 2, report));
    CHECK(map_hash(emulated.map) == expected);
  }
}

TEST_CASE("a card that fails to answer, or answers what cannot be, is lost") {
  const hal::CameraModel camera = test::small_camera(40);
  using Lie = std::function<void(const cuda::Queries&)>;
  const std::vector<Lie> lies{
      [](const cuda::Queries& q) { q.ray_hits[3].end = static_cast<RayEnd>(4); },
      [](const cuda::Queries& q) { q.ray_hits[0].distance_m = 1e9F; },
      [](const cuda::Queries& q) { q.ray_hits[1].distance_m = std::numeric_limits<float>::quiet_NaN(); },
      [](const cuda::Queries& q) { q.looks[0].gain.unknown_voxels = 0xFFFFFFFF; },
      [](const cuda::Queries& q) { q.looks[0].gain.near_rays = 40 * 40; },
  };
  const std::vector<BulkRay> rays(20, BulkRay{{0, 0, 0}, {1, 1, 0}, 3.0F, 0});
  for (std::size_t fault = 0; fault < lies.size() + 2; ++fault) {
    INFO("fault " << fault);
    test::EmulatedMapper emulated(small_config(), camera, 8);
    auto faulty = std::make_shared<test::FaultyCard>(emulated.card);
    emulated.twin.set_card(faulty);
    const LookModel model = cpu::look_model(emulated.sensor, 2);
    std::vector<BulkHit> hits(rays.size());
    std::vector<Look> looks{cpu::look_from(emulated.sensor, hal::to_transform(test::random_pose(1)))};
    CHECK(emulated.twin.cast_rays(rays, hits));
    CHECK(emulated.twin.count_looks(model, looks));
    looks[0].gain = {};
    if (fault < lies.size()) faulty->spoil_answers = lies[fault];
    faulty->fails_to_answer = fault == lies.size();
    if (fault == lies.size() + 1) emulated.map.clear();  // only an empty card can follow
    const bool both = emulated.twin.cast_rays(rays, hits) && emulated.twin.count_looks(model, looks);
    CHECK_FALSE(both);
  }
}

TEST_CASE("a map that was cleared needs a new card") {
  const hal::CameraModel camera = test::small_camera(60);
  test::EmulatedMapper emulated(small_config(), camera, 9);
  const auto frames = test::random_frames(camera, 2, 9);
  (void)emulated.integrate(frames[0].frame, frames[0].T_world_camera);
  emulated.map.clear();
  FrameReport report;
  const auto geometry = cpu::frame_geometry(emulated.sensor, hal::to_transform(frames[1].T_world_camera));
  CHECK_FALSE(emulated.twin.integrate(frames[1].frame, *geometry, true, 2, report));
  emulated.new_card(10);
  (void)emulated.integrate(frames[1].frame, frames[1].T_world_camera);
  Mapper fresh(small_config(), camera);
  (void)fresh.integrate(frames[1].frame, frames[1].T_world_camera);
  CHECK(map_hash(emulated.map) == map_hash(fresh.map()));
}

TEST_CASE("classes of what a frame changed are there before the mirror is, and say what it will be") {
  const hal::CameraModel camera = test::small_camera(80);
  test::EmulatedMapper emulated(small_config(), camera, 10);
  std::uint32_t number = 0;
  std::size_t uniform = 0;
  std::size_t mixed = 0;
  for (const auto& [frame, pose] : test::random_frames(camera, 4, 10)) {
    const std::string before = map_hash(emulated.map);
    FrameReport report;
    const auto geometry = cpu::frame_geometry(emulated.sensor, hal::to_transform(pose));
    REQUIRE(geometry);
    REQUIRE(emulated.twin.begin(frame, *geometry, true, ++number, report));
    CHECK(map_hash(emulated.map) == before);
    const cuda::ChangedClasses classes = emulated.twin.changed_classes();
    REQUIRE(emulated.twin.finish(report));
    REQUIRE(classes.heads.size() == emulated.twin.changed_slots().size());
    REQUIRE_FALSE(classes.heads.empty());
    for (std::size_t i = 0; i < classes.heads.size(); ++i) {
      BlockValues values;
      REQUIRE(emulated.map.read_block(classes.heads[i].key, values));
      const bool is_uniform = classes.heads[i].uniform != cuda::kNone;
      (is_uniform ? uniform : mixed) += 1;
      std::size_t different = 0;
      for (std::size_t place = 0; place < values.size(); ++place) {
        const State state = state_of(values[place]);
        const std::uint32_t expected = state == State::occupied ? 2 : state == State::free ? 1 : 0;
        const std::uint32_t told =
            is_uniform ? classes.heads[i].uniform : classes.planes[i].words[place / 16] >> (2 * (place % 16)) & 3U;
        different += told == expected ? 0 : 1;
      }
      CHECK(different == 0);
    }
  }
  CHECK(uniform > 0);
  CHECK(mixed > 0);
}
