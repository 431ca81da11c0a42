// SPDX-License-Identifier: Apache-2.0
// The card's map and its mirror stay equal, whoever changes which of them; and a card that lies or fails changes
// nothing.
#include "mapper/cuda/twin.hpp"

#include <catch2/catch.hpp>
#include <functional>

#include "mapper/map_hash.hpp"
#include "tests/support/emulated_mapper.hpp"
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

/// A card that passes everything on, until told to do something wrong.
class FaultyCard final : public cuda::Card {
 public:
  explicit FaultyCard(std::shared_ptr<cuda::Card> good) : good_(std::move(good)) {}
  cuda::FrameInput& input() override { return good_->input(); }
  std::uint16_t* depth() override { return good_->depth(); }
  std::uint8_t* rgb() override { return good_->rgb(); }
  const cuda::Parcels& parcels() override { return good_->parcels(); }
  std::uint32_t room() const override { return good_->room(); }
  bool import_blocks(std::uint32_t count) override { return good_->import_blocks(count) && !fails_to_import; }
  const cuda::Classes& classes() override { return good_->classes(); }
  std::uint32_t class_room() const override { return good_->class_room(); }
  bool begin_frame() override { return good_->begin_frame(); }
  bool finish_frame(cuda::FrameCounters& counters) override {
    const bool done = good_->finish_frame(counters);
    if (spoil) spoil(counters, good_->classes());
    return done && !fails_to_run;
  }
  bool send_blocks(std::uint32_t first) override {
    const bool done = good_->send_blocks(first);
    if (spoil_parcels) spoil_parcels(good_->parcels());
    return done && !fails_to_send;
  }

  bool fails_to_import = false;
  bool fails_to_run = false;
  bool fails_to_send = false;
  std::function<void(cuda::FrameCounters&, const cuda::Classes&)> spoil;
  std::function<void(const cuda::Parcels&)> spoil_parcels;

 private:
  std::shared_ptr<cuda::Card> good_;
};

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
  auto faulty = std::make_shared<FaultyCard>(emulated.card);
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
  using Lie = std::function<void(FaultyCard&)>;
  const auto about_frame = [](auto spoil) { return [spoil](FaultyCard& card) { card.spoil = spoil; }; };
  const auto about_parcels = [](auto spoil) { return [spoil](FaultyCard& card) { card.spoil_parcels = spoil; }; };
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
    auto faulty = std::make_shared<FaultyCard>(emulated.card);
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
