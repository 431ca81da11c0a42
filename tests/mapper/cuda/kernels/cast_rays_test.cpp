// SPDX-License-Identifier: Apache-2.0
// Questions to a map in an emulated card, in random order: the CPU twin's answers, bit by bit.
#include <catch2/catch.hpp>
#include <cstring>

#include "mapper/cpu/bulk_rays.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

MapperConfig small_config(float resolution_m) {
  MapperConfig config;
  config.resolution_m = resolution_m;
  config.capacity = {1U << 15, 1U << 14, 1U << 15};
  return config;
}

/// Uniform blocks of all three classes, and noisy ones, among what frames have left.
void add_blocks(VoxelMap& map, std::uint64_t seed) {
  const auto blocks = tests::random_map(seed, 300, map.grid().resolution_m);
  BlockValues values;
  for (const BlockKey key : blocks->sorted_keys()) {
    (void)blocks->read_stored_block(key, values);
    REQUIRE(map.write_block(key, values));
  }
  tests::Random random(seed);
  for (int i = 0; i < 60; ++i) {
    values.fill(i % 3 == 0 ? 2U : i % 3 == 1 ? 30U : 16U);
    const auto near = [&] { return 32768 + static_cast<std::int32_t>(random.below(96)) - 48; };
    REQUIRE(map.write_block(block_of(VoxelIndex{near(), near(), near()}), values));
  }
}

void check_equal(test::EmulatedMapper& emulated, std::uint64_t seed) {
  cpu::ThreadPool pool(1);
  const float resolution_m = emulated.config.resolution_m;
  // More rays and looks than there is room for at once.
  const std::vector<BulkRay> rays =
      test::random_rays(seed, 1700, resolution_m, 45.0 * static_cast<double>(resolution_m));
  REQUIRE(rays.size() > emulated.card->ray_room());
  std::vector<BulkHit> expected(rays.size());
  std::vector<BulkHit> hits(rays.size());
  cpu::cast_bulk_rays(emulated.map, rays, expected, pool);
  REQUIRE(emulated.twin.cast_rays(rays, hits));
  CHECK(test::same_hits(hits, expected));

  const LookModel model = cpu::look_model(emulated.sensor, 1 + static_cast<int>(seed % 3));
  std::vector<Look> looks;
  for (std::uint64_t i = 0; i < 5; ++i) {
    hal::Pose pose = test::random_pose(100 * seed + i);
    if (i == 3) pose.translation_m[0] = 1e6;
    looks.push_back(cpu::look_from(emulated.sensor, hal::to_transform(pose)));
  }
  REQUIRE(looks.size() > emulated.card->look_room());
  std::vector<Look> expected_looks = looks;
  cpu::LookCounter(emulated.sensor).count(emulated.map, model, expected_looks, pool);
  REQUIRE(emulated.twin.count_looks(model, looks));
  std::uint32_t unknown = 0;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    CHECK(looks[i].gain.unknown_voxels == expected_looks[i].gain.unknown_voxels);
    CHECK(looks[i].gain.blocked_rays == expected_looks[i].gain.blocked_rays);
    CHECK(looks[i].gain.near_rays == expected_looks[i].gain.near_rays);
    unknown += looks[i].gain.unknown_voxels;
  }
  CHECK(unknown > 0);
}

}  // namespace

TEST_CASE("questions to the card are answered as by the CPU twin, between frames and changes of the host",
          "[cuda][slow]") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const hal::CameraModel camera = test::small_camera(60);
    test::EmulatedMapper emulated(small_config(seed == 2 ? 0.1F : 0.05F), camera, seed);
    check_equal(emulated, seed);  // of a card that has seen nothing
    for (const auto& [frame, pose] : test::random_frames(camera, 2, seed)) {
      (void)emulated.integrate(frame, pose);
      check_equal(emulated, seed);
    }
    add_blocks(emulated.map, seed);
    check_equal(emulated, 10 + seed);
    REQUIRE(emulated.map.erase_block(emulated.map.sorted_keys()[7]));
    check_equal(emulated, 20 + seed);
    for (const std::uint32_t* word = emulated.card->memory().seen;
         word < emulated.card->memory().seen + emulated.card->look_room() * emulated.card->memory().seen_stride;
         ++word) {
      REQUIRE(*word == 0);
    }
  }
}

TEST_CASE("no questions, no answers", "[cuda]") {
  test::EmulatedMapper emulated(small_config(0.05F), test::small_camera(20), 4);
  CHECK(emulated.twin.cast_rays({}, {}));
  CHECK(emulated.twin.count_looks(cpu::look_model(emulated.sensor, 1), {}));
  emulated.twin.set_card(nullptr);
  CHECK_FALSE(emulated.twin.cast_rays({}, {}));
  CHECK_FALSE(emulated.twin.count_looks(cpu::look_model(emulated.sensor, 1), {}));
}
