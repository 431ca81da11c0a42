// SPDX-License-Identifier: Apache-2.0
#include "mapper/dirty_slots.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <thread>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;

TEST_CASE("every slot that was noted is taken once, in ascending order", "[mapper]") {
  constexpr std::uint32_t kSlots = 1000;
  mapper::DirtySlots dirty(kSlots);
  tests::Random random(1);
  for (int round = 0; round < 50; ++round) {
    std::set<std::uint32_t> plain;
    for (std::uint32_t i = random.below(200); i > 0; --i) {
      const std::uint32_t slot = random.below(kSlots);
      dirty.note(slot);
      plain.insert(slot);
    }
    std::vector<std::uint32_t> taken;
    dirty.take_each([&](std::uint32_t slot) { taken.push_back(slot); });
    CHECK(taken == std::vector<std::uint32_t>(plain.begin(), plain.end()));
  }
}

TEST_CASE("what one thread notes while another takes is never missed", "[mapper][threads]") {
  constexpr std::uint32_t kSlots = 256;
  constexpr std::uint32_t kRounds = 20000;
  mapper::DirtySlots dirty(kSlots);
  std::vector<std::atomic<std::uint32_t>> state(kSlots);
  std::vector<std::uint32_t> seen(kSlots, 0);
  std::atomic<bool> is_done{false};
  std::thread writer([&] {
    tests::Random random(2);
    for (std::uint32_t i = 1; i <= kRounds; ++i) {
      const std::uint32_t slot = random.below(kSlots);
      state[slot].store(i, std::memory_order_relaxed);
      dirty.note(slot);
    }
    is_done.store(true, std::memory_order_release);
  });
  const auto look = [&](std::uint32_t slot) { seen[slot] = state[slot].load(std::memory_order_relaxed); };
  while (!is_done.load(std::memory_order_acquire)) dirty.take_each(look);
  writer.join();
  dirty.take_each(look);
  for (std::uint32_t slot = 0; slot < kSlots; ++slot) CHECK(seen[slot] == state[slot].load());
}
