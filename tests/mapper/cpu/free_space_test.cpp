// SPDX-License-Identifier: Apache-2.0
// Scenes in which things move, come too near or give no reading, with every integrator: what was measured stays until
// it is seen through, what has gone goes, and no wall is tunnelled.
#include "mapper/cpu/free_space.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/test_frames.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr std::array kAllKinds{IntegratorKind::dda, IntegratorKind::bresenham, IntegratorKind::projective};
constexpr int kFps = 30;

/// A camera at rest that looks along +x at a wall 3.2 m away, in a world where somebody walks.
class Stage {
 public:
  Stage(const hal::Mover& walk, IntegratorKind kind, hal::CameraModel camera = test::small_camera(160))
      : frame_(hal::make_frame(camera)), renderer_(world_of(walk), options(camera)), mapper_(config(kind), camera) {}

  void play(int frames) {
    for (int i = 0; i < frames; ++i, ++number_) {
      renderer_.render(pose_, number_ * 1'000'000'000LL / kFps, static_cast<std::uint64_t>(number_), frame_);
      mapper_.integrate(frame_, pose_);
    }
  }
  [[nodiscard]] const VoxelMap& map() const { return mapper_.map(); }
  /// Occupied voxels with centres in the box.
  [[nodiscard]] std::set<MCode> occupied(std::array<double, 3> low_m, std::array<double, 3> high_m) const {
    std::set<MCode> found;
    BlockValues values;
    for (const BlockKey key : map().sorted_keys()) {
      map().read_block(key, values);
      for (MCode place = 0; place < kBlockVoxels; ++place) {
        if (state_of(values[place]) != State::occupied) continue;
        const auto c = map().grid().centre_m(decode((key << kBlockShift) | place));
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) inside &= c[a] > low_m[a] && c[a] < high_m[a];
        if (inside) found.insert((key << kBlockShift) | place);
      }
    }
    return found;
  }
  [[nodiscard]] std::size_t still_occupied(const std::set<MCode>& voxels) const {
    return static_cast<std::size_t>(std::count_if(
        voxels.begin(), voxels.end(), [&](MCode code) { return state_of(map().at(code)) == State::occupied; }));
  }

 private:
  static hal::World world_of(const hal::Mover& walk) {
    hal::World world;
    world.add_box({3.3, 0.0, -2.0}, {0.2, 12.0, 6.0}, 0.0, {});
    world.add_person(1.75, 0.25, {}, walk);
    return world;
  }
  static hal::SimRendererOptions options(const hal::CameraModel& camera) {
    hal::SimRendererOptions options;
    options.camera = camera;
    return options;
  }
  static MapperConfig config(IntegratorKind kind) {
    MapperConfig config;
    config.integrator = kind;
    config.capacity = {1U << 13, 1U << 12, 1U << 13};
    return config;
  }

  const hal::Pose pose_ = hal::camera_pose({0.0, 0.0, 1.2}, 0.0, 0.0);
  std::int64_t number_ = 0;
  hal::Frame frame_;
  hal::SimRenderer renderer_;
  Mapper mapper_;
};

const std::array<double, 3> kPersonLow_m{0.6, -0.4, 0.85};  // the part that the camera sees from nearby
const std::array<double, 3> kPersonHigh_m{1.6, 0.4, 1.55};

}  // namespace

TEST_CASE("somebody who comes too near is not erased, and is gone half a second after leaving the view", "[slow]") {
  for (const IntegratorKind kind : kAllKinds) {
    // Stands at 1.2 m for a second, comes up to 0.65 m (too near) and 0.55 m (no reading at all), leaves sideways.
    const hal::Mover walk{{{0.0, 1.2, 0.0},
                           {1.0, 1.2, 0.0},
                           {1.4, 0.9, 0.0},
                           {2.0, 0.9, 0.0},
                           {2.2, 0.7, 0.0},
                           {4.0, 0.7, 0.0},
                           {5.0, 0.7, 3.0}}};
    Stage stage(walk, kind);
    stage.play(30);
    const auto standing = stage.occupied(kPersonLow_m, kPersonHigh_m);
    INFO(to_string(kind) << ", " << standing.size() << " voxels of the person");
    CHECK(standing.size() > 50);
    stage.play(90);  // nearer and nearer, then two seconds right in front of the camera
    CHECK(stage.still_occupied(standing) == standing.size());
    stage.play(18);  // out of the view at 4.4 s at the latest
    stage.play(15);  // and half a second more
    CHECK(stage.occupied(kPersonLow_m, kPersonHigh_m).empty());
  }
}

TEST_CASE("somebody who stood for long and walks away is gone within half a second", "[slow]") {
  for (const IntegratorKind kind : kAllKinds) {
    const hal::Mover walk{{{0.0, 1.8, 0.0}, {3.0, 1.8, 0.0}, {3.5, 1.8, 2.5}}};
    Stage stage(walk, kind);
    stage.play(90);
    INFO(to_string(kind));
    CHECK(stage.occupied({1.3, -0.3, 0.5}, {2.3, 0.3, 1.8}).size() > 100);
    stage.play(5);  // 0.83 m on: the person's width has been left, but for the last frame
    stage.play(15);
    CHECK(stage.occupied({1.3, -0.3, 0.5}, {2.3, 0.3, 1.8}).empty());
  }
}

TEST_CASE("the wall behind somebody who stands in front of it stays", "[slow]") {
  for (const IntegratorKind kind : kAllKinds) {
    const hal::Mover walk{{{0.0, 1.5, 4.0}, {2.0, 1.5, 4.0}, {3.0, 1.5, 0.0}, {5.0, 0.7, 0.0}}};
    Stage stage(walk, kind);
    stage.play(60);
    const auto wall = stage.occupied({3.1, -0.8, 0.7}, {3.4, 0.8, 1.7});
    INFO(to_string(kind) << ", " << wall.size() << " voxels of the wall");
    CHECK(wall.size() > 500);
    stage.play(120);
    CHECK(static_cast<double>(stage.still_occupied(wall)) >= 0.98 * static_cast<double>(wall.size()));  // but for noise
  }
}

TEST_CASE("a hand over the camera, or a black cloth over half the view, frees nothing", "[slow]") {
  const hal::CameraModel camera = test::small_camera(160);
  const hal::Pose pose = hal::camera_pose({0.0, 0.0, 1.2}, 0.0, 0.0);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, camera);
    hal::Frame frame = hal::make_frame(camera);
    std::uint16_t* depth = frame.depth.get();
    std::fill_n(depth, camera.pixel_count(), std::uint16_t{2000});
    for (int i = 0; i < 10; ++i) mapper.integrate(frame, pose);
    const MapCounts before = mapper.map().counts();
    CHECK(before.occupied > 1000);
    // Blind in the middle, bounded by readings that are too near, by nothing, by readings beyond the wall.
    for (const int bound : {700, 0, 5000}) {
      std::fill_n(depth, camera.pixel_count(), std::uint16_t{0});
      for (int v = 0; v < camera.height_px; ++v) {
        depth[v * camera.width_px] = static_cast<std::uint16_t>(bound);
        depth[v * camera.width_px + camera.width_px - 1] = static_cast<std::uint16_t>(bound);
      }
      for (int i = 0; i < 30; ++i) mapper.integrate(frame, pose);
      const MapCounts after = mapper.map().counts();
      INFO(to_string(kind) << ", bounded by " << bound);
      // In the last case the two columns at the border do see through the wall, where they look at it.
      CHECK(after.occupied >= before.occupied - (bound == 5000 ? before.occupied / 8 : 0));
      if (bound != 5000) CHECK(after.free == before.free);
    }
  }
}

TEST_CASE("no closed wall is tunnelled: hardly a free voxel lies behind one after a noisy drive", "[slow]") {
  const test::Workload work = test::simulated_drive("two_rooms", 60, 0.5, 0.0, 160);
  REQUIRE(work.frames.size() >= 30);
  for (const IntegratorKind kind : kAllKinds) {
    MapperConfig config;
    config.integrator = kind;
    Mapper mapper(config, work.camera);
    for (const auto& [frame, pose] : work.frames) mapper.integrate(frame, pose);
    // The western room: x -4.05..-0.05, y -2..2, z 0..2.4, walls of 10 cm around it.
    const std::array<double, 3> low_m{-4.15, -2.1, -0.1};
    const std::array<double, 3> high_m{0.05, 2.1, 2.5};
    std::uint64_t free = 0;
    std::uint64_t behind = 0;
    BlockValues values;
    for (const BlockKey key : mapper.map().sorted_keys()) {
      mapper.map().read_block(key, values);
      for (MCode place = 0; place < kBlockVoxels; ++place) {
        if (state_of(values[place]) != State::free) continue;
        const auto c = mapper.map().grid().centre_m(decode((key << kBlockShift) | place));
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) inside &= c[a] > low_m[a] && c[a] < high_m[a];
        ++free;
        behind += inside ? 0 : 1;
      }
    }
    INFO(to_string(kind) << ": " << behind << " of " << free << " free voxels lie behind walls");
    CHECK(free > 100000);
    CHECK(static_cast<double>(behind) <= 0.001 * static_cast<double>(free));
  }
}
