// SPDX-License-Identifier: Apache-2.0
#include "hal/frame_watch.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "hal/sim/load_world.hpp"
#include "hal/sim/sim_building.hpp"

using namespace g3d::hal;

namespace {

constexpr TimeNs kMs = 1'000'000;

// A camera that looks at something oblique, with a little noise that is never the same.
struct Bench {
  CameraModel camera = scaled_kinect(160, 120);
  FrameWatch watch;
  Frame frame;
  TimeNs now_ns = 5'000 * kMs;
  PlanarPose pose;
  std::uint32_t seed = 7;

  Bench() { frame.depth = std::make_unique<std::uint16_t[]>(camera.pixel_count()); }
  std::uint32_t random() { return seed = seed * 1664525U + 1013904223U, seed >> 16; }
  void fill(const std::function<std::uint32_t(std::size_t)>& depth_at) {
    for (std::size_t i = 0; i < camera.pixel_count(); ++i) frame.depth[i] = static_cast<std::uint16_t>(depth_at(i));
  }
  void see() {
    fill([&](std::size_t i) { return 1'000 + 10 * (i % 160) + random() % 5; });
  }
  void see_noise() {
    fill([&](std::size_t) { return random(); });
  }
  FrameFault check(TimeNs age_ns = 20 * kMs) {
    now_ns += 100 * kMs;
    frame.stamp_ns = now_ns - age_ns;
    return watch.check(frame, camera, pose, now_ns);
  }
};

}  // namespace

TEST_CASE("What a camera sees is good, standing or driving") {
  Bench bench;
  for (int i = 0; i < 50; ++i) {
    bench.see();
    bench.pose.x_m += i < 25 ? 0.05 : 0.0;
    CHECK(bench.check() == FrameFault::none);
  }
  CHECK(bench.watch.counts()[0] == 50);
}

TEST_CASE("The same image again is wrong only where the base has moved") {
  Bench bench;
  bench.see();
  for (int i = 0; i < 20; ++i) CHECK(bench.check() == FrameFault::none);
  for (int i = 0; i < 10; ++i) {
    bench.pose.x_m += 0.005;
    CHECK((bench.check() == FrameFault::stuck) == (bench.pose.x_m > 0.03));
  }
  bench.see();
  CHECK(bench.check() == FrameFault::none);
  for (int i = 0; i < 10; ++i) {
    bench.pose.heading_rad += 0.01;
    (void)bench.check();
  }
  CHECK(bench.check() == FrameFault::stuck);
  CHECK(bench.watch.counts()[static_cast<std::size_t>(FrameFault::stuck)] > 5);
}

TEST_CASE("A heading that wraps is no turn") {
  Bench bench;
  bench.see();
  bench.pose.heading_rad = 3.14159;
  CHECK(bench.check() == FrameFault::none);
  bench.pose.heading_rad = -3.14159;
  CHECK(bench.check() == FrameFault::none);
}

TEST_CASE("Noise is garbage") {
  Bench bench;
  for (int i = 0; i < 20; ++i) {
    bench.see_noise();
    CHECK(bench.check() == FrameFault::garbage);
  }
  bench.see();
  CHECK(bench.check() == FrameFault::none);
}

TEST_CASE("No reading at all is what a near wall looks like") {
  Bench bench;
  for (int i = 0; i < 20; ++i) {
    bench.pose.heading_rad += 0.1;
    bench.fill([](std::size_t) { return 0U; });
    CHECK(bench.check() == FrameFault::none);
  }
}

TEST_CASE("Old images, images from the future, and stamps that stand still") {
  Bench bench;
  bench.see();
  CHECK(bench.check(300 * kMs) == FrameFault::none);
  CHECK(bench.check(301 * kMs) == FrameFault::old);
  CHECK(bench.check(-50 * kMs) == FrameFault::none);
  CHECK(bench.check(-51 * kMs) == FrameFault::old);
  bench.see();
  CHECK(bench.check() == FrameFault::none);
  CHECK(bench.watch.check(bench.frame, bench.camera, bench.pose, bench.now_ns) == FrameFault::old);
}

TEST_CASE("Images of the simulated camera in a cluttered place are good", "[slow]") {
  for (const std::string world_name : {"furnished_room", "corridor"}) {
    INFO(world_name);
    auto world = load_world(world_name);
    REQUIRE(world.ok());
    for (const int width_px : {160, 640}) {
      SimBuildingOptions options;
      options.camera = scaled_kinect(width_px, width_px * 3 / 4);
      options.robots.resize(1);
      SimBuilding building(world.value(), options);
      Frame frame;
      frame.depth = std::make_unique<std::uint16_t[]>(options.camera.pixel_count());
      frame.rgb = std::make_unique<std::uint8_t[]>(3 * options.camera.pixel_count());
      FrameWatch watch;
      PlanarPose pose;
      for (int i = 0; i < 12; ++i) {
        pose.heading_rad = i * 0.5;
        building.place(0, pose);
        building.advance_to(building.now() + 100 * kMs);
        building.render(0, frame);
        frame.stamp_ns = building.now();
        CHECK(watch.check(frame, options.camera, pose, building.now()) == FrameFault::none);
      }
    }
  }
}

TEST_CASE("Every fault has a name") {
  std::set<std::string> names;
  for (int i = 0; i < static_cast<int>(FrameFault::count_); ++i) names.insert(to_string(static_cast<FrameFault>(i)));
  CHECK(names.size() == static_cast<std::size_t>(FrameFault::count_));
}
