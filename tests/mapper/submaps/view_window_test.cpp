// SPDX-License-Identifier: Apache-2.0
// The promise: what the view holds and what the submaps hold is, together and at any time, the map that a view without
// a window would have been.
#include "mapper/submaps/view_window.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "mapper/block_source.hpp"
#include "mapper/rolling_window.hpp"
#include "tests/support/submap_walk.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;
using tests::SubmapWalk;

namespace {

constexpr ChainOptions kOnlyWhenAsked{.most_way_m = 1e9, .most_turn_rad = 1e9, .most_s = 1e9};

/// Whether a view has all blocks that it would have without a window, but for the regions that are out.
bool is_view_right(const SubmapWalk& paged, const SubmapWalk& unlimited) {
  BlockValues values;
  BlockValues expected;
  std::vector<BlockKey> keys = unlimited.chain.view().sorted_keys();
  std::erase_if(keys, [&](BlockKey key) { return paged.window->is_out(region_of(key)); });
  return keys == paged.chain.view().sorted_keys() && std::all_of(keys.begin(), keys.end(), [&](BlockKey key) {
           return paged.chain.view().read_stored_block(key, values) &&
                  unlimited.chain.view().read_stored_block(key, expected) && values == expected;
         });
}

/// Where each submap stands after a correction that bends the way.
std::vector<hal::Pose> bent(std::size_t count) {
  std::vector<hal::Pose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const auto n = static_cast<double>(i);
    poses.push_back(hal::from_xyz_rpy(0.03 * n, -0.02 * n, 0.0, 0.0, 0.0, 0.004 * n));
  }
  return poses;
}

hal::Pose looking(double x_m, double yaw_rad) {
  constexpr double kHalfPi = 1.5707963267948966;
  return hal::from_xyz_rpy(x_m, 0.0, 1.1, -kHalfPi, 0.0, yaw_rad - kHalfPi);
}

MapCapacity part_of(const SubmapWalk& unlimited, double part) {
  const auto blocks = static_cast<std::uint32_t>(part * static_cast<double>(unlimited.blocks()));
  return {blocks, blocks, 2 * blocks};
}

}  // namespace

TEST_CASE("view and submaps are together the map without a window, to the bit", "[submaps][window][slow]") {
  SubmapWalk unlimited;
  SubmapWalk paged;
  paged.open_window();
  int compared = 0;
  std::uint32_t most_blocks = 0;
  for (int i = 0; i < 400; ++i) {
    const hal::Pose pose = unlimited.walk.pose(i);
    unlimited.step(pose);
    const bool is_end = paged.step(pose);
    most_blocks = std::max(most_blocks, paged.blocks());
    if (!is_end && i % 70 != 0) continue;
    ++compared;
    REQUIRE(paged.hash() == unlimited.hash());
    CHECK(is_view_right(paged, unlimited));
  }
  CHECK(compared > 15);
  CHECK(paged.refused == 0);
  const ViewWindowCounts& counts = paged.window->counts();
  CHECK(counts.regions_out > 20);
  CHECK(counts.regions_in > 20);
  CHECK(counts.regions_out - counts.regions_in == paged.window->out_count());
  CHECK(counts.blocks_out > counts.blocks_in);
  CHECK(counts.blocks_in > 100);
  CHECK(counts.refused_blocks == 0);
  CHECK(counts.smallest_radius_m == paged.window->full_radius_m());
  CHECK(most_blocks < unlimited.blocks());
  CHECK(paged.shelf.counts().put_away > 5);
  CHECK(paged.shelf.counts().fetched > 5);
  CHECK(paged.shelf.counts().failed_stores + paged.shelf.counts().failed_loads == 0);
  CHECK(paged.chain.submaps().size() == unlimited.chain.submaps().size());
}

TEST_CASE("a radius is raised to what the sensor's reach needs", "[submaps][window]") {
  SubmapWalk paged;
  const double least_m = least_radius_m(tests::CorridorWalk::camera(), paged.mapper.config().far_m, 0.05F);
  paged.open_window(1.0);
  CHECK(paged.window->full_radius_m() == Approx(least_m).margin(0.05));
  CHECK(paged.window->full_radius_m() >= least_m);
  paged.open_window(20.0);
  CHECK(paged.window->full_radius_m() == Approx(20.0).margin(0.05));
}

TEST_CASE("what has changed since the last submap does not leave the view", "[submaps][window][slow]") {
  SubmapWalk unlimited(kOnlyWhenAsked);
  SubmapWalk paged(kOnlyWhenAsked);
  paged.open_window();
  unlimited.go(110);  // 22 m
  paged.go(110);
  CHECK(paged.window->counts().regions_out == 0);
  CHECK(paged.blocks() == unlimited.blocks());
  REQUIRE(paged.chain.finish_submap());
  unlimited.go(5);
  paged.go(5);
  CHECK(paged.window->counts().regions_out > 0);
  CHECK(paged.blocks() < unlimited.blocks());
  CHECK(paged.hash() == unlimited.hash());
  CHECK(is_view_right(paged, unlimited));
}

TEST_CASE("what was known before the first frame does not leave before it is in a submap", "[submaps][window]") {
  SubmapWalk paged;
  BlockValues values;
  values.fill(3);
  const BlockKey far = block_of({32768 + 2000, 32768, 32768});
  REQUIRE(paged.mapper.map().write_block(far, values));
  paged.open_window();
  paged.go(10);
  CHECK(paged.chain.view().find(far) != kNoSlot);
  REQUIRE(paged.chain.finish_submap());
  paged.go(10);
  CHECK(paged.chain.view().find(far) == kNoSlot);
  CHECK(paged.window->is_out(region_of(far)));
  BlockValues read;
  REQUIRE(paged.chain.read_block(far, read));
  CHECK(read == values);
}

TEST_CASE("the view's window shrinks before a pool refuses, and ends submaps for it", "[submaps][window][slow]") {
  SubmapWalk unlimited;
  unlimited.walk.length_m = 48.0;
  unlimited.go(300);
  // A submap ends by itself, or never but for want of memory.
  const ChainOptions options = GENERATE(ChainOptions{}, kOnlyWhenAsked);
  SubmapWalk paged(options, part_of(unlimited, 0.45));
  paged.walk.length_m = 48.0;
  paged.open_window(1000.0);
  paged.go(300);
  CHECK(paged.refused == 0);
  CHECK(paged.window->counts().refused_blocks == 0);
  CHECK(paged.window->counts().smallest_radius_m < 100.0);
  CHECK(paged.window->full_radius_m() > 999.0);
  CHECK(paged.chain.submaps().size() > 1);
  CHECK(paged.hash() == unlimited.hash());
  CHECK(is_view_right(paged, unlimited));
}

TEST_CASE("whoever jumps and turns on the spot finds all as it was left, with little memory",
          "[submaps][window][slow]") {
  constexpr double kBack_rad = 3.14;
  std::vector<hal::Pose> poses;
  for (int i = 0; i < 100; ++i) poses.push_back(looking(0.4 * i, 0.3));
  // From where memory is full of what lies to one side, to where what lies to the other side is missing.
  for (int i = 0; i < 3; ++i) poses.push_back(looking(1.0, 0.0));
  for (int i = 0; i < 6; ++i) poses.push_back(looking(22.0, i < 3 ? 0.0 : kBack_rad));
  SubmapWalk unlimited;
  for (const hal::Pose& pose : poses) unlimited.step(pose);
  SubmapWalk paged({}, part_of(unlimited, GENERATE(0.52, 0.62)));
  paged.open_window(24.0);
  for (const hal::Pose& pose : poses) paged.step(pose);
  CHECK(paged.refused == 0);
  CHECK(paged.window->counts().refused_blocks == 0);
  CHECK(paged.window->counts().regions_in > 10);
  CHECK(paged.window->counts().smallest_radius_m < paged.window->full_radius_m());
  CHECK(paged.hash() == unlimited.hash());
}

TEST_CASE("nothing comes and goes while a camera stays or sways", "[submaps][window][slow]") {
  SubmapWalk paged;
  paged.open_window();
  paged.go(130);
  REQUIRE(paged.chain.finish_submap());
  const auto sway = [&] {
    for (int i = 0; i < 60; ++i) paged.step(paged.walk.pose(130 + i % 3));  // 0.4 m to and fro
  };
  sway();
  REQUIRE(paged.window->out_count() > 0);
  const std::uint64_t out = paged.window->counts().regions_out;
  const std::uint64_t in = paged.window->counts().regions_in;
  sway();
  CHECK(paged.window->counts().regions_out == out);
  CHECK(paged.window->counts().regions_in == in);
}

TEST_CASE("a frame outside of the grid moves nothing in the view", "[submaps][window]") {
  SubmapWalk paged;
  paged.open_window();
  paged.go(50);
  REQUIRE(paged.chain.finish_submap());
  const std::uint32_t blocks = paged.blocks();
  paged.step(hal::from_xyz_rpy(1e6, 0, 0, 0, 0, 0));
  CHECK(paged.blocks() == blocks);
  CHECK(paged.window->counts().regions_out == 0);
}

TEST_CASE("all comes back at the end, if the view can hold it", "[submaps][window][slow]") {
  SubmapWalk unlimited;
  unlimited.go(200);
  SubmapWalk paged;
  paged.open_window();
  paged.go(200);
  paged.chain.finish_submap();
  const std::size_t out = paged.window->out_count();
  REQUIRE(out > 0);
  REQUIRE(paged.window->gather());
  CHECK(paged.window->out_count() == 0);
  CHECK(map_hash(paged.chain.view()) == map_hash(unlimited.chain.view()));
  CHECK(paged.hash() == unlimited.hash());
  CHECK(paged.chain.in_memory() <= SubmapBlocks::kKept);

  const auto needed = measure(MemoryBlocks(unlimited.chain.view())).value().needed;
  SubmapWalk tight({}, needed);
  tight.open_window();
  tight.go(200);
  tight.chain.finish_submap();
  REQUIRE(tight.window->gather());
  CHECK(map_hash(tight.chain.view()) == map_hash(unlimited.chain.view()));
  CHECK(tight.window->counts().refused_blocks == 0);

  SubmapWalk small({}, {needed.blocks - 1, needed.planes, needed.colour_bricks});
  small.open_window();
  small.go(200);
  small.chain.finish_submap();
  const std::uint32_t blocks = small.blocks();
  CHECK_FALSE(small.window->gather());
  CHECK(small.blocks() == blocks);
  CHECK(small.window->out_count() > 0);
  CHECK(small.hash() == unlimited.hash());
}

TEST_CASE("after a correction the view around the camera is that of a whole that is made anew",
          "[submaps][window][slow]") {
  SubmapWalk unlimited;
  SubmapWalk paged;
  paged.open_window();
  const int frames = GENERATE(150, 220);  // far from where it began, and on the way back
  unlimited.go(frames);
  paged.go(frames);
  unlimited.chain.finish_submap();
  paged.chain.finish_submap();
  const std::string before = unlimited.hash();
  REQUIRE(paged.hash() == before);
  const std::size_t count = unlimited.chain.submaps().size();
  REQUIRE(count > 5);
  unlimited.chain.place(bent(count));
  unlimited.chain.rebuild();
  paged.chain.place(bent(count));
  paged.window->rebuild(paged.last_pose);
  CHECK(unlimited.hash() != before);
  CHECK(paged.hash() == unlimited.hash());
  CHECK(is_view_right(paged, unlimited));
  CHECK(paged.window->out_count() > 0);
  CHECK(paged.blocks() > 100);

  // And so it goes on.
  unlimited.go(100);
  paged.go(100);
  CHECK(paged.hash() == unlimited.hash());
  CHECK(is_view_right(paged, unlimited));
  CHECK(paged.chain.refused_blocks() + paged.window->counts().refused_blocks == 0);
}

TEST_CASE("a disk that takes nothing costs memory, and nothing of the map", "[submaps][window][slow]") {
  SubmapWalk unlimited;
  unlimited.go(250);
  SubmapWalk paged;
  paged.disk->full_at_bytes = GENERATE(0U, 100'000U);
  paged.open_window();
  paged.go(250);
  CHECK(paged.shelf.counts().failed_stores > 0);
  CHECK(paged.window->counts().regions_out > 0);  // of submaps that are in memory
  CHECK(paged.hash() == unlimited.hash());
  CHECK(paged.shelf.first_error().find("full") != std::string::npos);
}

TEST_CASE("a submap that was spoiled on disk is counted, and the others are there", "[submaps][window][slow]") {
  SubmapWalk unlimited;
  unlimited.go(320);
  SubmapWalk paged;
  paged.open_window();
  paged.go(150);
  REQUIRE(paged.shelf.size() > 0);
  paged.disk->spoil(40);
  paged.go(170);  // back to where it began
  CHECK(paged.shelf.counts().failed_loads == 1);
  CHECK(paged.shelf.first_error().find("checksum") != std::string::npos);
  const auto size = measure(SubmapBlocks(paged.chain, *paged.window));
  REQUIRE(size.ok());
  CHECK(size.value().counts.blocks > unlimited.blocks() / 2);
}
