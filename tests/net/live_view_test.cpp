// SPDX-License-Identifier: Apache-2.0
#include "net/live_view.hpp"

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "mapper/block_merge.hpp"
#include "mapper/block_source.hpp"
#include "mapper/map_hash.hpp"

using namespace g3d;

namespace {

constexpr mapper::MapCapacity kViewCapacity{4096, 512, 64};

mapper::BlockValues view_block(std::uint8_t level) {
  mapper::BlockValues values;
  values.fill(level);
  return values;
}

}  // namespace

TEST_CASE("what the others have seen comes into the view with the next turn, merged with what is our own", "[net]") {
  mapper::VoxelMap own({0.1F}, kViewCapacity);
  mapper::VoxelMap others({0.1F}, kViewCapacity);
  net::LiveView view(own);
  REQUIRE(own.write_block(7, view_block(20)));
  CHECK(view.on_own(own, std::array{own.find(7)}).size() == 1);
  REQUIRE(others.write_block(7, view_block(24)));
  REQUIRE(others.write_block(9, view_block(8)));
  CHECK(view.take_news().empty());
  const std::array<mapper::BlockKey, 2> keys{7, 9};
  view.offer(keys, others);
  CHECK(view.take_news().size() == 2);
  mapper::BlockValues values;
  REQUIRE(view.map().read_stored_block(7, values));
  CHECK(mapper::level_of(values[0]) == 28);
  REQUIRE(view.map().read_stored_block(9, values));
  CHECK(mapper::level_of(values[0]) == 8);
  // Another robot's pose was corrected: the block is elsewhere now.
  REQUIRE(others.erase_block(9));
  view.offer(std::array<mapper::BlockKey, 1>{9}, others);
  CHECK(view.take_news().size() == 1);
  CHECK_FALSE(view.map().read_stored_block(9, values));
  CHECK(view.refused_blocks() == 0);
}

TEST_CASE("more news than the ring holds wait, coalesce, and are not lost", "[net]") {
  mapper::VoxelMap own({0.1F}, kViewCapacity);
  mapper::VoxelMap others({0.1F}, kViewCapacity);
  net::LiveView view(own);
  std::vector<mapper::BlockKey> keys;
  for (mapper::BlockKey key = 1; key <= 2000; ++key) {
    REQUIRE(others.write_block(key, view_block(10)));
    keys.push_back(key);
  }
  view.offer(keys, others);
  CHECK(view.due() == 2000 - net::LiveView::kBlocksAtOnce);
  REQUIRE(others.write_block(2000, view_block(30)));
  view.offer(keys, others);  // all of them once more: those that wait do so once
  CHECK(view.due() == 2000);
  std::size_t taken = 0;
  while (view.due() > 0 || taken == 0) {
    taken += view.take_news().size();
    view.offer({}, others);
  }
  taken += view.take_news().size();
  CHECK(taken == 2000 + net::LiveView::kBlocksAtOnce);
  CHECK(mapper::map_hash(view.map()) == mapper::map_hash(others));
}

TEST_CASE("news go from thread to thread while both work", "[net][threads]") {
  mapper::VoxelMap own({0.1F}, kViewCapacity);
  mapper::VoxelMap others({0.1F}, kViewCapacity);
  net::LiveView view(own);
  std::atomic<bool> ended{false};
  std::thread sharing([&] {
    std::vector<mapper::BlockKey> changed;
    for (int round = 0; round < 40; ++round) {
      changed.clear();
      for (mapper::BlockKey key = 1; key <= 300; ++key) {
        if ((key + static_cast<mapper::BlockKey>(round)) % 3 != 0) continue;
        if (round % 5 == 4) {
          (void)others.erase_block(key);
        } else {
          (void)others.write_block(key, view_block(static_cast<std::uint8_t>(1 + (round + key) % 15)));
        }
        changed.push_back(key);
      }
      view.offer(changed, others);
    }
    while (view.due() > 0) view.offer({}, others);
    ended.store(true, std::memory_order_release);
  });
  std::size_t taken = 0;
  for (bool is_last = false; !is_last;) {
    is_last = ended.load(std::memory_order_acquire);
    for (std::size_t some = 1; some > 0; taken += some) some = view.take_news().size();
  }
  sharing.join();
  CHECK(taken > 300);
  CHECK(mapper::map_hash(view.map()) == mapper::map_hash(others));
}
