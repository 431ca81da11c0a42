// SPDX-License-Identifier: Apache-2.0
#include "net/byte_ring.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <thread>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using mapper::Bytes;
using net::ByteRing;

TEST_CASE("a ring of byte strings does what a deque does, and refuses only what does not fit", "[net]") {
  tests::Random random(11);
  ByteRing ring(1000);
  REQUIRE(ring.capacity_bytes() == 1024);
  std::deque<Bytes> plain;
  std::size_t used = 0;
  int refused = 0;
  Bytes popped;
  for (int step = 0; step < 20000; ++step) {
    REQUIRE(ring.free_bytes() == 1024 - used);
    REQUIRE(ring.empty() == plain.empty());
    if (random.below(2) == 0) {
      Bytes string(random.below(random.below(10) == 0 ? 1100 : 60));
      for (std::uint8_t& byte : string) byte = static_cast<std::uint8_t>(random.next());
      const bool fits = used + 4 + string.size() <= 1024;
      REQUIRE(ring.try_push(string) == fits);
      refused += fits ? 0 : 1;
      if (!fits) continue;
      used += 4 + string.size();
      plain.push_back(string);
    } else {
      REQUIRE(ring.try_pop(popped) == !plain.empty());
      if (plain.empty()) continue;
      REQUIRE(popped == plain.front());
      used -= 4 + popped.size();
      plain.pop_front();
    }
  }
  CHECK(refused > 100);
}

TEST_CASE("strings cross a ring between two threads whole and in order", "[net][threads]") {
  constexpr std::uint32_t kStrings = 20000;
  ByteRing ring(4096);
  std::thread consumer([&] {
    Bytes popped;
    for (std::uint32_t n = 0; n < kStrings;) {
      if (!ring.try_pop(popped)) {
        std::this_thread::yield();
        continue;
      }
      const Bytes expected(n % 300, static_cast<std::uint8_t>(n));
      if (popped != expected) std::abort();
      ++n;
    }
  });
  for (std::uint32_t n = 0; n < kStrings;) {
    if (ring.try_push(Bytes(n % 300, static_cast<std::uint8_t>(n)))) {
      ++n;
    } else {
      std::this_thread::yield();
    }
  }
  consumer.join();
  CHECK(ring.empty());
}
