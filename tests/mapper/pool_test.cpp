// SPDX-License-Identifier: Apache-2.0
#include "mapper/pool.hpp"

#include <sys/mman.h>

#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d::mapper;
using g3d::tests::Random;

TEST_CASE("a reserved array is zero at first and after a reset") {
  ReservedArray<std::uint32_t> array(5000);
  CHECK(array.size() == 5000);
  CHECK(array.size_bytes() >= 5000 * sizeof(std::uint32_t));
  for (std::size_t i = 0; i < array.size(); ++i) REQUIRE(array[i] == 0);
  for (std::size_t i = 0; i < array.size(); ++i) array[i] = static_cast<std::uint32_t>(i) + 1;
  CHECK(array.data()[4999] == 5000);
  array.reset();
  for (std::size_t i = 0; i < array.size(); ++i) REQUIRE(array[i] == 0);
}

TEST_CASE("reserving far more than there is memory costs nothing until it is touched") {
  ReservedArray<std::uint8_t> array(std::size_t{1} << 36);  // 64 GiB
  array[(std::size_t{1} << 36) - 1] = 7;
  CHECK(array[(std::size_t{1} << 36) - 1] == 7);
}

TEST_CASE("what is touched is in memory, and holds what it held") {
  constexpr std::size_t kPage_bytes = 4096;
  ReservedArray<std::uint8_t> array(64 * kPage_bytes);
  array[5] = 9;
  array.touch(16 * kPage_bytes);
  std::array<unsigned char, 64> is_resident{};
  REQUIRE(mincore(array.data(), 64 * kPage_bytes, is_resident.data()) == 0);
  for (std::size_t page = 0; page < 16; ++page) CHECK((is_resident[page] & 1U) == 1U);
  CHECK(array[5] == 9);
  array.touch(array.size_bytes() * 2);  // no more than there is
  CHECK(array[5] == 9);
  CHECK(array[64 * kPage_bytes - 1] == 0);
}

TEST_CASE("a pool hands out each slot once and says when it is full") {
  SlotPool<int> pool(100);
  std::set<std::uint32_t> taken;
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t slot = pool.take();
    REQUIRE(slot < 100);
    REQUIRE(taken.insert(slot).second);
    pool[slot] = i;
  }
  CHECK(pool.take() == SlotPool<int>::kNone);
  CHECK(pool.in_use() == 100);
  CHECK(pool.available() == 0);
  pool.give_back(42);
  CHECK(pool.available() == 1);
  CHECK(pool.take() == 42);
  CHECK(pool.take() == SlotPool<int>::kNone);
}

TEST_CASE("a pool of nothing is always full") {
  SlotPool<int> pool(0);
  CHECK(pool.take() == SlotPool<int>::kNone);
  CHECK(pool.capacity() == 0);
}

TEST_CASE("random taking and giving back never hands a slot to two users") {
  Random random(3);
  SlotPool<std::uint64_t> pool(64);
  std::vector<std::uint32_t> mine;
  for (std::uint64_t step = 0; step < 20000; ++step) {
    if (random.below(2) == 0) {
      const std::uint32_t slot = pool.take();
      REQUIRE((slot == SlotPool<std::uint64_t>::kNone) == (mine.size() == 64));
      if (slot == SlotPool<std::uint64_t>::kNone) continue;
      mine.push_back(slot);
      pool[slot] = slot + 1000U;
    } else if (!mine.empty()) {
      const std::size_t which = random.below(static_cast<std::uint32_t>(mine.size()));
      REQUIRE(pool[mine[which]] == mine[which] + 1000U);
      pool[mine[which]] = 0;
      pool.give_back(mine[which]);
      mine[which] = mine.back();
      mine.pop_back();
    }
    REQUIRE(pool.in_use() == mine.size());
    REQUIRE(pool.available() == 64 - mine.size());
    REQUIRE(pool.high_water() <= 64);
  }
  pool.reset();
  CHECK(pool.in_use() == 0);
  CHECK(pool.high_water() == 0);
  const std::uint32_t slot = pool.take();
  CHECK(pool[slot] == 0);
}
