// SPDX-License-Identifier: Apache-2.0
// What the mapper promises whatever the integrator: the same map for any number of threads, changed blocks, full pools,
// modes, and refusing what lies outside of the grid. That maps are right is shown in cpu/*_test.cpp.
#include "mapper/mapper.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "mapper/map_hash.hpp"
#include "tests/support/plain_mapper.hpp"
#include "tests/support/test_frames.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr std::array kAllKinds{IntegratorKind::dda, IntegratorKind::bresenham, IntegratorKind::projective};

/// All blocks with what outsiders see of them.
std::map<BlockKey, BlockValues> snapshot(const VoxelMap& map) {
  std::map<BlockKey, BlockValues> blocks;
  for (const BlockKey key : map.sorted_keys()) map.read_block(key, blocks[key]);
  return blocks;
}

struct Run {
  std::string hash;
  std::uint64_t refused = 0;
};

Run run(const MapperConfig& config, const hal::CameraModel& camera, const std::vector<test::PosedImage>& frames) {
  Mapper mapper(config, camera);
  Run result;
  for (const auto& [frame, pose] : frames) {
    const FrameReport report = mapper.integrate(frame, pose);
    result.refused += report.refused_blocks;
    CHECK((report.status == FrameStatus::pool_full) == (report.refused_blocks > 0));
  }
  result.hash = map_hash(mapper.map());
  return result;
}

}  // namespace

TEST_CASE("names of integrators and modes go there and back") {
  for (const IntegratorKind kind : kAllKinds) CHECK(integrator_from_string(to_string(kind)) == kind);
  for (const MapMode mode : {MapMode::static_mode, MapMode::dynamic_mode})
    CHECK(mode_from_string(to_string(mode)) == mode);
  CHECK(std::string(to_string(IntegratorKind::projective)) == "projective");
  CHECK(std::string(to_string(MapMode::static_mode)) == "static");
  CHECK_FALSE(integrator_from_string("DDA"));
  CHECK_FALSE(integrator_from_string(""));
  CHECK_FALSE(mode_from_string("dda"));
}

TEST_CASE("cameras and resolutions that no memory could serve are refused with a remedy") {
  MapperConfig config;
  CHECK_FALSE(config_problem(config, hal::CameraModel{}));
  config.resolution_m = 0.002F;
  CHECK_FALSE(config_problem(config, hal::CameraModel{}));
  config.integrator = IntegratorKind::dda;
  REQUIRE(config_problem(config, hal::CameraModel{}));
  CHECK(config_problem(config, hal::CameraModel{})->find("--resolution") != std::string::npos);
  config.resolution_m = 0.005F;
  CHECK_FALSE(config_problem(config, hal::CameraModel{}));
  hal::CameraModel fisheye;
  fisheye.fx_px = 1e-3F;
  REQUIRE(config_problem(config, fisheye));
  CHECK(config_problem(config, fisheye)->find("camera.txt") != std::string::npos);
}

// These maps must be the same on every processor, with every compiler and in every later version: who changes one on
// purpose changes the contract in the README's map section, too.
TEST_CASE("a short simulated drive has its golden hashes", "[slow]") {
  const test::Workload work = test::simulated_drive("furnished_room", 8, 1.0, 0.0, 160);
  REQUIRE(work.frames.size() == 8);
  const std::map<IntegratorKind, std::string> golden{
      {IntegratorKind::dda, "8182fb5b108dbdd6154e828ac626506bc7892826dc19d2a19abbafb0547ca6a8"},
      {IntegratorKind::bresenham, "b1eba80ecd63e15013db48bf79662e387081ad71efcfcfac157ec7a636829957"},
      {IntegratorKind::projective, "dfa1a5dfddc8552f87191e0838186c841622c6f7ab029b500f56fd9dd9c0421b"}};
  for (const auto& [kind, hash] : golden) {
    MapperConfig config;
    config.integrator = kind;
    INFO(to_string(kind));
    CHECK(run(config, work.camera, work.frames).hash == hash);
    test::PlainMapper plain(config, work.camera);
    for (const auto& [frame, pose] : work.frames) plain.integrate(frame, pose);
    CHECK(plain.hash() == hash);
  }
}

TEST_CASE("the same frames give the same map for any number of threads", "[threads]") {
  const hal::CameraModel camera = test::small_camera(100);
  const auto frames = test::random_frames(camera, 6, 1);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    config.capacity = {1U << 14, 1U << 13, 1U << 14};
    const Run one = run(config, camera, frames);
    CHECK(one.refused == 0);
    for (const int threads : {2, 3}) {
      config.threads = threads;
      CHECK(run(config, camera, frames).hash == one.hash);
    }
  }
}

TEST_CASE("full pools refuse blocks, are reported, and leave the same map for any number of threads", "[threads]") {
  const hal::CameraModel camera = test::small_camera(80);
  const auto frames = test::random_frames(camera, 6, 2);
  const std::array<MapCapacity, 5> tiny{
      {{0, 0, 0}, {40, 1000, 1000}, {1000, 30, 1000}, {1000, 1000, 20}, {300, 100, 100}}};
  for (const IntegratorKind kind : kAllKinds) {
    for (const MapCapacity& capacity : tiny) {
      MapperConfig config;
      config.integrator = kind;
      config.capacity = capacity;
      const Run one = run(config, camera, frames);
      CHECK(one.refused > 0);
      config.threads = 3;
      const Run three = run(config, camera, frames);
      CHECK(three.hash == one.hash);
      CHECK(three.refused == one.refused);
    }
  }
}

TEST_CASE("a pool that is full of colour refuses the colour alone") {
  const hal::CameraModel camera = test::small_camera(80);
  const auto frames = test::random_frames(camera, 4, 3);
  MapperConfig config;
  config.capacity = {1U << 13, 1U << 12, 0};
  Mapper without_bricks(config, camera);
  config.capacity.colour_bricks = 1U << 13;
  config.with_colour = false;
  Mapper without_colour(config, camera);
  for (const auto& [frame, pose] : frames) {
    CHECK(without_bricks.integrate(frame, pose).refused_blocks > 0);
    CHECK(without_colour.integrate(frame, pose).refused_blocks == 0);
  }
  CHECK(map_hash(without_bricks.map()) == map_hash(without_colour.map()));
  CHECK(without_colour.map().counts().coloured == 0);
  CHECK(without_colour.map().counts().occupied > 0);
}

TEST_CASE("a frame without colour image changes levels as one with colour does") {
  const hal::CameraModel camera = test::small_camera(80);
  auto frames = test::random_frames(camera, 3, 4);
  MapperConfig config;
  config.with_colour = false;
  const Run expected = run(config, camera, frames);
  for (auto& image : frames) image.frame.has_colour = false;
  config.with_colour = true;
  CHECK(run(config, camera, frames).hash == expected.hash);
}

TEST_CASE("changed_slots names exactly the blocks whose published values differ, each once") {
  const hal::CameraModel camera = test::small_camera(80);
  for (const IntegratorKind kind : kAllKinds) {
    for (const MapMode mode : {MapMode::dynamic_mode, MapMode::static_mode}) {
      MapperConfig config;
      config.integrator = kind;
      config.mode = mode;
      config.resolution_m = 0.1F;
      config.threads = 2;
      Mapper mapper(config, camera);
      CHECK(mapper.changed_slots().empty());
      auto before = snapshot(mapper.map());
      // Long enough at one place that voxels saturate and blocks stop changing.
      auto frames = test::random_frames(camera, 8, 5);
      for (int i = 0; i < 40; ++i) {
        const auto& [frame, pose] = frames[static_cast<std::size_t>(i < 8 ? i : 7)];
        mapper.integrate(frame, pose);
        auto after = snapshot(mapper.map());
        std::set<BlockKey> different;
        for (const auto& [key, values] : after) {
          const auto old = before.find(key);
          if (old == before.end() || old->second != values) different.insert(key);
        }
        std::set<BlockKey> reported;
        for (const std::uint32_t slot : mapper.changed_slots())
          REQUIRE(reported.insert(mapper.map().header(slot).key).second);
        INFO(to_string(kind) << " " << to_string(mode) << " frame " << i);
        REQUIRE(reported == different);
        for (const auto& [key, values] : before) REQUIRE(after.contains(key));
        before = std::move(after);
      }
      CHECK(mapper.changed_slots().size() < before.size());
    }
  }
}

TEST_CASE("static mode registers occupied voxels alone, the same with every integrator") {
  const hal::CameraModel camera = test::small_camera(80);
  const auto frames = test::random_frames(camera, 8, 6);
  std::set<std::string> hashes;
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    config.mode = MapMode::static_mode;
    Mapper mapper(config, camera);
    test::PlainMapper plain(config, camera);
    for (const auto& [frame, pose] : frames) {
      mapper.integrate(frame, pose);
      plain.integrate(frame, pose);
    }
    CHECK(mapper.map().counts().free == 0);
    CHECK(mapper.map().counts().occupied > 1000);
    CHECK(plain.differences(mapper.map()) == "");
    hashes.insert(map_hash(mapper.map()));
  }
  CHECK(hashes.size() == 1);
}

TEST_CASE("a pose outside of the grid is reported and changes nothing") {
  const hal::CameraModel camera = test::small_camera(40);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, camera);
    const hal::Frame frame = test::random_frame(camera, 1);
    hal::Pose pose;
    CHECK(mapper.integrate(frame, pose).status == FrameStatus::integrated);
    const std::string hash = map_hash(mapper.map());
    for (const double x_m : {1637.0, -1637.0, 1e6, -1e12, 1e300}) {
      pose.translation_m = {0.0, x_m, 0.0};
      const FrameReport report = mapper.integrate(frame, pose);
      CHECK(report.status == FrameStatus::out_of_range);
      CHECK(report.valid_pixels == 0);
    }
    CHECK(map_hash(mapper.map()) == hash);
    pose.translation_m = {0.0, 1630.0, 0.0};  // the last place that still fits
    CHECK(mapper.integrate(frame, pose).status == FrameStatus::integrated);
  }
}

TEST_CASE("the report counts pixels by what they are") {
  const hal::CameraModel camera = test::small_camera(40);
  Mapper mapper({}, camera);
  test::PosedImage image{test::random_frame(camera, 1), {}};
  std::uint16_t* depth = image.frame.depth.get();
  std::fill_n(depth, camera.pixel_count(), std::uint16_t{2000});
  std::fill_n(depth, 10, std::uint16_t{0});
  std::fill_n(depth + 10, 20, std::uint16_t{799});
  std::fill_n(depth + 30, 40, std::uint16_t{3501});
  depth[70] = 800;
  depth[71] = 3500;
  const FrameReport report = mapper.integrate(image.frame, image.T_world_camera);
  CHECK(report.status == FrameStatus::integrated);
  CHECK(report.invalid_pixels == 10);
  CHECK(report.too_near_pixels == 20);
  CHECK(report.far_pixels == 40);
  CHECK(report.valid_pixels == camera.pixel_count() - 70);
  CHECK(report.hit_blocks > 0);
  CHECK(report.refused_blocks == 0);
}

TEST_CASE("what is too near neither marks nor carves, an image without any reading does nothing") {
  const hal::CameraModel camera = test::small_camera(160);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, camera);
    hal::Frame frame = test::random_frame(camera, 1);
    for (const std::uint16_t raw : {0, 1, 799}) {
      std::fill_n(frame.depth.get(), camera.pixel_count(), raw);
      mapper.integrate(frame, {});
      CHECK(mapper.map().counts().known() == 0);
      CHECK(mapper.changed_slots().empty());
    }
    std::fill_n(frame.depth.get(), camera.pixel_count(), std::uint16_t{9000});
    mapper.integrate(frame, {});
    CHECK(mapper.map().counts().occupied == 0);
    CHECK(mapper.map().counts().free > 1000);
    CHECK(state_of(mapper.map().at(VoxelIndex{32768, 32768, 32768 + 60})) == State::free);     // 3.0 m
    CHECK(state_of(mapper.map().at(VoxelIndex{32768, 32768, 32768 + 72})) == State::unknown);  // 3.6 m
  }
}

TEST_CASE("rays past the outline of what is too near do not free the voxels in which it lies", "[slow]") {
  const hal::CameraModel camera = test::small_camera(160);
  for (const IntegratorKind kind : kAllKinds) {
    INFO(to_string(kind));
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, camera);
    hal::Frame frame = test::random_frame(camera, 1);
    std::uint16_t* depth = frame.depth.get();
    const auto see_post = [&](int width_px, std::uint16_t raw) {
      std::fill_n(depth, camera.pixel_count(), std::uint16_t{3000});
      for (int v = 0; v < camera.height_px; ++v) std::fill_n(depth + v * camera.width_px + 80, width_px, raw);
    };
    const VoxelIndex post{32768, 32768, 32768 + 15};  // 0.75 to 0.8 m in front of the camera: 9 pixels wide
    see_post(9, 800);
    for (int i = 0; i < 6; ++i) mapper.integrate(frame, hal::from_xyz_rpy(0.0, 0.0, -0.03, 0.0, 0.0, 0.0));
    REQUIRE(state_of(mapper.map().at(post)) == State::occupied);
    // Nearer, two pixels of it still have a reading. What lies beside them gets as free as can be.
    see_post(2, 790);
    for (int i = 0; i < 60; ++i) mapper.integrate(frame, {});
    CHECK(state_of(mapper.map().at(post)) == State::occupied);
    CHECK(state_of(mapper.map().at(VoxelIndex{32768 + 3, 32768, 32768 + 15})) == State::free);
    CHECK(state_of(mapper.map().at(VoxelIndex{32768, 32768, 32768 + 12})) == State::free);
    // It goes a little nearer: what nothing holds any more is freed; where it is now stays what it was.
    see_post(2, 710);
    for (int i = 0; i < 60; ++i) mapper.integrate(frame, {});
    CHECK(state_of(mapper.map().at(post)) == State::free);
    Mapper fresh(config, camera);
    for (int i = 0; i < 60; ++i) fresh.integrate(frame, {});
    CHECK(fresh.map().at(VoxelIndex{32768, 32768, 32768 + 14}) == kUnknownRgbo);
    CHECK(state_of(fresh.map().at(VoxelIndex{32768, 32768, 32768 + 15})) == State::free);
  }
}

TEST_CASE("the footprint is free, and what was known before is kept") {
  const hal::CameraModel camera = test::small_camera(40);
  MapperConfig config;
  Mapper mapper(config, camera);
  BlockValues values;
  values.fill(kUnknownRgbo);
  const VoxelIndex wall = Grid{config.resolution_m}.to_index(0.1F, 0.0F, 0.1F);
  values[encode(wall) & kPlaceMask] = 32;
  REQUIRE(mapper.map().write_block(block_of(wall), values));
  mapper.free_footprint({0.02, -0.03, 0.0}, 0.2, 0.4);
  int free = 0;
  for (std::int32_t z = 32740; z < 32800; ++z) {
    for (std::int32_t y = 32740; y < 32800; ++y) {
      for (std::int32_t x = 32740; x < 32800; ++x) {
        const State state = state_of(mapper.map().at(VoxelIndex{x, y, z}));
        if (VoxelIndex{x, y, z} == wall) {
          REQUIRE(state == State::occupied);
          continue;
        }
        const auto c = mapper.map().grid().centre_m(VoxelIndex{x, y, z});
        const double distance_m = std::hypot(c[0] - 0.02, c[1] + 0.03);
        if (distance_m < 0.199 && c[2] > 0.001 && c[2] < 0.399) REQUIRE(state == State::free);
        if (distance_m > 0.2 + 0.05 || c[2] < -0.06 || c[2] > 0.46) REQUIRE(state == State::unknown);
        free += state == State::free ? 1 : 0;
      }
    }
  }
  CHECK(free > 8 * 50);
  const std::string hash = map_hash(mapper.map());
  mapper.free_footprint({1e7, 0.0, 0.0}, 0.2, 0.4);  // outside: nothing happens
  CHECK(map_hash(mapper.map()) == hash);
}

TEST_CASE("a recorded scan mask bounds what pixels without a reading may free") {
  const hal::CameraModel camera = test::small_camera(80);
  std::vector<std::uint16_t> mask(camera.pixel_count());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = static_cast<std::uint16_t>(i % 80 < 40 ? 1500 : 0);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, camera, mask);
    test::PlainMapper plain(config, camera, mask);
    for (const auto& [frame, pose] : test::random_frames(camera, 4, 7)) {
      mapper.integrate(frame, pose);
      plain.integrate(frame, pose);
    }
    CHECK(plain.differences(mapper.map()) == "");
  }
}
