// SPDX-License-Identifier: Apache-2.0
#include "hal/ring.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "hal/clock.hpp"
#include "hal/messages.hpp"

using namespace g3d::hal;

namespace {

// Larger than a word and not a multiple of it, so that a mixture of two values would show.
struct Message {
  std::uint64_t a = 0;
  std::uint64_t b = 0;
  std::uint32_t c = 0;

  static Message of(std::uint64_t n) { return {n, ~n, static_cast<std::uint32_t>(n * 2654435761U)}; }
  [[nodiscard]] bool whole() const { return b == ~a && c == static_cast<std::uint32_t>(a * 2654435761U); }
};

}  // namespace

TEST_CASE("A ring keeps order, refuses when full and says when empty") {
  for (const std::size_t capacity : {1U, 2U, 3U, 5U, 8U}) {
    Ring<int> ring(capacity);
    CHECK(ring.capacity() == capacity);
    int out = 0;
    int next_in = 0;
    int next_out = 0;
    for (int round = 0; round < 20; ++round) {
      CHECK_FALSE(ring.try_pop(out));
      while (ring.try_push(next_in)) ++next_in;
      CHECK(ring.size() == capacity);
      CHECK(next_in - next_out == static_cast<int>(capacity));
      while (ring.try_pop(out)) {
        REQUIRE(out == next_out);
        ++next_out;
      }
      CHECK(ring.empty());
      CHECK(next_out == next_in);
    }
    CHECK(ring.dropped() == 0);
  }
}

TEST_CASE("Capacity zero is taken as one") {
  Ring<int> ring(0);
  CHECK(ring.try_push(1));
  CHECK_FALSE(ring.try_push(2));
}

TEST_CASE("push_overwrite_oldest hands back what it took out, and counts it") {
  Ring<int> ring(3);
  for (int i = 0; i < 3; ++i) CHECK_FALSE(ring.push_overwrite_oldest(i).has_value());
  CHECK(ring.push_overwrite_oldest(3) == 0);
  CHECK(ring.push_overwrite_oldest(4) == 1);
  CHECK(ring.dropped() == 2);
  CHECK(ring.size() == 3);
  int out = 0;
  for (const int expected : {2, 3, 4}) {
    REQUIRE(ring.try_pop(out));
    CHECK(out == expected);
  }
  CHECK_FALSE(ring.try_pop(out));
  CHECK(ring.try_push(9));
  CHECK(ring.try_pop(out));
  CHECK(out == 9);
}

TEST_CASE("Messages of every size cross unchanged") {
  Ring<PosedFrame> ring(2);
  const PosedFrame in{7, from_xyz_rpy(1, 2, 3, 0.1, 0.2, 0.3)};
  CHECK(ring.try_push(in));
  PosedFrame out;
  REQUIRE(ring.try_pop(out));
  CHECK(out.frame_index == 7);
  CHECK(out.T_world_camera.translation_m == in.T_world_camera.translation_m);
  CHECK(out.T_world_camera.rotation_xyzw == in.T_world_camera.rotation_xyzw);
}

namespace {

constexpr TimeNs kLongest_ns = 2'000'000'000;  // beside other work every turn may cost a time slice

}  // namespace

TEST_CASE("Two threads: nothing is lost and nothing is out of order", "[threads]") {
  constexpr std::uint64_t kCount = 200'000;
  Ring<Message> ring(7);
  std::atomic<std::uint64_t> sent{kCount};
  std::thread producer([&] {
    const RealClock clock;
    const TimeNs end_ns = clock.now() + kLongest_ns;
    std::uint64_t i = 0;
    for (; i < kCount && clock.now() < end_ns; ++i) {
      while (!ring.try_push(Message::of(i))) std::this_thread::yield();
    }
    sent.store(i, std::memory_order_release);
  });
  std::uint64_t bad = 0;
  std::uint64_t expected = 0;
  Message out;
  while (expected < sent.load(std::memory_order_acquire)) {
    if (!ring.try_pop(out)) {
      std::this_thread::yield();
      continue;
    }
    if (out.a != expected || !out.whole()) ++bad;
    ++expected;
  }
  producer.join();
  CHECK(bad == 0);
  CHECK(expected > 1000);
  CHECK_FALSE(ring.try_pop(out));
}

TEST_CASE("Two threads: overwriting loses only what it counts and returns", "[threads]") {
  constexpr std::uint64_t kCount = 30'000;
  for (const std::size_t capacity : {1U, 2U, 5U}) {
    Ring<Message> ring(capacity);
    std::atomic<bool> done{false};
    std::uint64_t returned = 0;
    std::uint64_t returned_sum = 0;
    std::uint64_t bad = 0;
    std::thread producer([&] {
      std::uint64_t bad_returned = 0;
      for (std::uint64_t i = 1; i <= kCount; ++i) {
        if (const auto oldest = ring.push_overwrite_oldest(Message::of(i))) {
          if (!oldest->whole()) ++bad_returned;
          ++returned;
          returned_sum += oldest->a;
        }
        if (i % 64 == 0) std::this_thread::yield();
      }
      bad += bad_returned;  // the consumer reads it after join
      done.store(true, std::memory_order_release);
    });
    std::uint64_t popped = 0;
    std::uint64_t popped_sum = 0;
    std::uint64_t last = 0;
    std::uint64_t bad_popped = 0;
    Message out;
    for (;;) {
      const bool was_done = done.load(std::memory_order_acquire);
      if (ring.try_pop(out)) {
        if (!out.whole() || out.a <= last) ++bad_popped;
        last = out.a;
        ++popped;
        popped_sum += out.a;
      } else if (was_done) {
        break;
      }
    }
    producer.join();
    CHECK(bad == 0);
    CHECK(bad_popped == 0);
    CHECK(last == kCount);
    CHECK(popped + returned == kCount);
    CHECK(popped_sum + returned_sum == kCount * (kCount + 1) / 2);
    CHECK(ring.dropped() == returned);
  }
}
