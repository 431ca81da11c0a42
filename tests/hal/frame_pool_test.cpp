// SPDX-License-Identifier: Apache-2.0
#include "hal/frame_pool.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <set>
#include <thread>

#include "hal/clock.hpp"

using namespace g3d::hal;

TEST_CASE("A pool hands out each frame once, with storage of its own") {
  CameraModel model;
  model.width_px = 8;
  model.height_px = 4;
  FramePool pool(model, 3);
  CHECK(pool.count() == 3);
  CHECK(pool.free_count() == 3);
  std::set<std::uint32_t> indices;
  std::set<const void*> storage;
  std::uint32_t index = 0;
  while (pool.try_acquire(index)) {
    indices.insert(index);
    std::fill_n(pool[index].depth.get(), model.pixel_count(), std::uint16_t{1});
    std::fill_n(pool[index].rgb.get(), 3 * model.pixel_count(), std::uint8_t{2});
    storage.insert(pool[index].depth.get());
    storage.insert(pool[index].rgb.get());
  }
  CHECK(indices == std::set<std::uint32_t>{0, 1, 2});
  CHECK(storage.size() == 6);
  CHECK(pool.free_count() == 0);
  pool.release(1);
  REQUIRE(pool.try_acquire(index));
  CHECK(index == 1);
  CHECK_FALSE(pool.try_acquire(index));
}

TEST_CASE("Frames go round between camera and mapper without being seen by both", "[threads]") {
  CameraModel model;
  model.width_px = 16;
  model.height_px = 1;
  constexpr std::uint64_t kFrames = 20'000;
  FramePool pool(model, 3);
  Ring<std::uint32_t> under_way(3);
  std::atomic<std::uint64_t> sent{kFrames};
  std::thread camera([&] {
    const RealClock clock;
    const TimeNs end_ns = clock.now() + 2'000'000'000;  // beside other work every turn may cost a time slice
    std::uint64_t i = 0;
    for (; i < kFrames && clock.now() < end_ns; ++i) {
      std::uint32_t index = 0;
      while (!pool.try_acquire(index)) std::this_thread::yield();
      pool[index].sequence = i;
      std::fill_n(pool[index].depth.get(), model.pixel_count(), static_cast<std::uint16_t>(i));
      while (!under_way.try_push(index)) std::this_thread::yield();
    }
    sent.store(i, std::memory_order_release);
  });
  std::uint64_t bad = 0;
  std::uint64_t i = 0;
  for (std::uint32_t index = 0; i < sent.load(std::memory_order_acquire);) {
    if (!under_way.try_pop(index)) {
      std::this_thread::yield();
      continue;
    }
    const Frame& frame = pool[index];
    const auto expected = static_cast<std::uint16_t>(i);
    if (frame.sequence != i) ++bad;
    if (std::count(frame.depth.get(), frame.depth.get() + model.pixel_count(), expected) != 16) ++bad;
    pool.release(index);
    ++i;
  }
  camera.join();
  CHECK(i > 100);
  CHECK(bad == 0);
  CHECK(pool.free_count() == 3);
}
