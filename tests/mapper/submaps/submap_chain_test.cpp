// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/submap_chain.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "mapper/map_hash.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/memory_page_file.hpp"
#include "tests/support/test_frames.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;
using namespace g3d::mapper::submaps;

namespace {

MapperConfig config_with_room() {
  MapperConfig config;
  config.capacity = {1U << 15, 1U << 14, 1U << 15};
  return config;
}

/// A drive whose frames go into `mapper`, a submap finished whenever the chain says so and at the end.
template <typename AfterSubmap>
void drive(Mapper& mapper, SubmapChain& chain, const test::Workload& work, AfterSubmap&& after_submap) {
  for (std::size_t i = 0; i < work.frames.size(); ++i) {
    const auto& [frame, pose] = work.frames[i];
    mapper.integrate(frame, pose);
    const bool due = chain.add_frame(frame.stamp_ns, pose, mapper.changed_slots());
    if (due || i + 1 == work.frames.size()) {
      REQUIRE(chain.finish_submap());
      after_submap();
    }
  }
}

std::string hash_of(SubmapChain& chain, const VoxelMap& like) {
  VoxelMap map(like.grid(), like.capacity());
  BlockValues values;
  for (const BlockKey key : like.sorted_keys()) {
    if (chain.read_block(key, values)) REQUIRE(map.write_block(key, values));
  }
  return map_hash(map);
}

}  // namespace

TEST_CASE("as long as no pose is corrected the chain is the view, to the bit", "[slow]") {
  const test::Workload work = test::simulated_drive("furnished_room", 40, 10.0, 0.0, 160);
  Mapper mapper(config_with_room(), work.camera);
  SubmapChain chain(mapper.map(), {.most_way_m = 0.8});
  mapper.free_footprint(work.frames.front().T_world_camera.translation_m, 0.2, 0.3);
  drive(mapper, chain, work, [&] { REQUIRE(hash_of(chain, mapper.map()) == map_hash(mapper.map())); });
  REQUIRE(chain.submaps().size() >= 4);
  const std::string before = map_hash(mapper.map());
  chain.rebuild();
  CHECK(map_hash(mapper.map()) == before);
  // What is seen again and stays as it is takes no room in a later submap.
  CHECK(chain.submaps().back().contents->get().voxels->counts().known() <
        chain.submaps().front().contents->get().voxels->counts().known());
  double way_m = 0.0;
  for (const Submap& submap : chain.submaps()) {
    CHECK(submap.first_ns <= submap.last_ns);
    way_m += submap.way_m;
  }
  CHECK(way_m > 1.0);
  CHECK(chain.memory_bytes() > 0);
  CHECK_FALSE(chain.finish_submap());
}

TEST_CASE("a submap that is moved takes its voxels with it, and the newest that knows a voxel says what it is") {
  VoxelMap view(Grid{0.05F}, {256, 256, 256});
  SubmapChain chain(view);
  const VoxelIndex wall{32768 + 8, 32768, 32768};
  const auto write = [&](const VoxelIndex& v, Rgbo code) {
    BlockValues values;
    view.read_stored_block(block_of(v), values);
    values[encode(v) & kPlaceMask] = code;
    REQUIRE(view.write_block(block_of(v), values));
    return view.find(block_of(v));
  };
  const std::uint32_t first_slot = write(wall, 32);
  chain.add_frame(1, {}, std::array{first_slot});
  REQUIRE(chain.finish_submap());
  // Seen again two voxels farther on, and no longer where it was.
  const std::array slots{write(wall, 4), write({wall.x + 2, wall.y, wall.z}, 30)};
  chain.add_frame(2, hal::from_xyz_rpy(1, 0, 0, 0, 0, 0), slots);
  REQUIRE(chain.finish_submap());
  REQUIRE(chain.submaps().size() == 2);
  CHECK(chain.submaps()[1].way_m == Approx(1.0));

  const hal::Pose back = hal::from_xyz_rpy(-0.1, 0.0, 0.0, 0.0, 0.0, 0.0);
  chain.place(std::array{hal::Pose{}, back});
  chain.rebuild();
  CHECK(level_of(view.at(wall)) == 30);
  CHECK(level_of(view.at({wall.x - 2, wall.y, wall.z})) == 4);
  CHECK(view.at({wall.x + 2, wall.y, wall.z}) == kUnknownRgbo);
  CHECK(chain.correction_at(1).translation_m[0] == 0.0);
  CHECK(chain.correction_at(2).translation_m[0] == -0.1);
  CHECK(chain.correction_at(3).translation_m[0] == 0.0);  // of no submap yet

  // A third one begins in the corrected view, and holds what it changes there.
  chain.add_frame(4, {}, std::array{write(wall, 2)});
  REQUIRE(chain.finish_submap());
  CHECK(chain.submaps()[2].contents->get().voxels->counts().known() == 1);
  const std::string hash = map_hash(view);
  chain.rebuild();
  CHECK(map_hash(view) == hash);
}

TEST_CASE("blocks that no submap reaches any more leave the view") {
  VoxelMap view(Grid{0.05F}, {64, 64, 64});
  SubmapChain chain(view);
  BlockValues values;
  values.fill(3);
  const BlockKey key = block_of({32768, 32768, 32768});
  REQUIRE(view.write_block(key, values));
  chain.add_frame(1, {}, {});  // what is there before the first frame belongs to the first submap
  REQUIRE(chain.finish_submap());
  chain.place(std::array{hal::from_xyz_rpy(4.0, 0.0, 0.0, 0.0, 0.0, 0.0)});
  chain.rebuild();
  CHECK_FALSE(view.read_block(key, values));
  CHECK(level_of(view.at({32768 + 80, 32768, 32768})) == 3);
  CHECK(view.block_count() == 1);
}

TEST_CASE("a submap is finished after some way, some turning or some time") {
  VoxelMap view(Grid{0.05F}, {64, 64, 64});
  SubmapChain chain(view, {.most_way_m = 2.0, .most_turn_rad = 1.0, .most_s = 5.0});
  const auto at = [](double x_m, double yaw_rad) { return hal::from_xyz_rpy(x_m, 0, 0, 0, 0, yaw_rad); };
  CHECK_FALSE(chain.add_frame(0, at(0, 0), {}));
  CHECK_FALSE(chain.add_frame(1, at(1.9, 0), {}));
  CHECK(chain.add_frame(2, at(2.1, 0), {}));
  REQUIRE(chain.finish_submap());
  CHECK(chain.submaps()[0].T_stored_anchor.translation_m[0] == 1.9);
  CHECK_FALSE(chain.add_frame(3, at(3.0, 0), {}));  // counted from the end, not from the anchor
  CHECK_FALSE(chain.add_frame(4, at(3.0, 0.6), {}));
  CHECK(chain.add_frame(5, at(3.0, 0.0), {}));  // there and back is turning, too
  REQUIRE(chain.finish_submap());
  CHECK(chain.submaps()[1].way_m == Approx(1.1));
  CHECK_FALSE(chain.add_frame(6, at(3.0, 0.0), {}));
  CHECK(chain.add_frame(6 + 5'000'000'000, at(3.0, 0.0), {}));
}

TEST_CASE("the surroundings of an anchor hold what a part of the chain has shown, in its frame") {
  VoxelMap view(Grid{0.05F}, {64, 64, 64});
  SubmapChain chain(view);
  const auto space_with = [](const VoxelIndex& v, Rgbo code) {
    auto space = std::make_unique<VoxelMap>(Grid{0.1F}, MapCapacity{4, 4, 8});
    BlockValues values;
    values.fill(kUnknownRgbo);
    values[encode(v) & kPlaceMask] = code;
    REQUIRE(space->write_block(block_of(v), values));
    return space;
  };
  // A wall one metre before the camera, which looks along x: seen twice by a robot that went two metres back.
  const hal::Pose looks_along_x = hal::look_at({0, 0, 0}, {1, 0, 0});
  std::vector<align::DepthSample> wall;
  for (int i = 0; i < 40; ++i) wall.push_back({{0.02F * static_cast<float>(i % 5), 0.01F, 1.0F}, {0, 0, -1}, 1.0F});
  hal::Pose second = looks_along_x;
  second.translation_m[0] = -2.0;
  chain.add_frame(1, looks_along_x, {}, wall);
  REQUIRE(chain.finish_submap(space_with({32768 + 5, 32768, 32768}, 3)));
  chain.add_frame(2, second, {}, wall);
  REQUIRE(chain.finish_submap(space_with({32768 - 15, 32768, 32768}, 30)));

  const Surroundings own = chain.surroundings(0, 1, 0);
  REQUIRE(own.space != nullptr);
  REQUIRE(!own.surfaces.empty());
  for (const align::DepthSample& sample : own.surfaces) {
    CHECK(sample.point_m[2] == Approx(1.0F).margin(0.002));  // the anchor is the camera
    CHECK(sample.normal[2] == Approx(-1.0F).margin(0.01));
  }
  CHECK(own.space->counts().known() == 1);

  // Corrected by half a metre along x, both in the frame of the first: the second wall is 1.5 m behind the first.
  chain.place(std::array{hal::Pose{}, hal::from_xyz_rpy(0.5, 0, 0, 0, 0, 0)});
  const Surroundings both = chain.surroundings(0, 2, 0);
  float nearest_m = 9.0F;
  for (const align::DepthSample& sample : both.surfaces) nearest_m = std::min(nearest_m, sample.point_m[2]);
  CHECK(nearest_m == Approx(-0.5F).margin(0.002));
  CHECK(both.space->counts().known() >= 2);
  CHECK(both.space->counts().occupied >= 1);

  chain.add_frame(3, second, {});
  REQUIRE(chain.finish_submap());  // nobody has sketched its space
  CHECK(chain.surroundings(2, 3, 2).space == nullptr);
}

TEST_CASE("time in which odometry alone knew the way is counted from anchor to anchor") {
  VoxelMap view(Grid{0.05F}, {64, 64, 64});
  SubmapChain chain(view);
  constexpr hal::TimeNs kSecond = 1'000'000'000;
  const auto at = [](double x_m) { return hal::from_xyz_rpy(x_m, 0, 0, 0, 0, 0); };
  chain.add_frame(0, at(0), {});
  chain.add_frame(1 * kSecond, at(1), {}, {}, true);
  chain.add_frame(2 * kSecond, at(2), {}, {}, true);
  REQUIRE(chain.finish_submap());
  CHECK(chain.submaps()[0].anchor_ns == 1 * kSecond);
  CHECK(chain.submaps()[0].held_s == Approx(1.0));
  chain.add_frame(3 * kSecond, at(3), {});
  REQUIRE(chain.finish_submap());
  CHECK(chain.submaps()[1].held_s == Approx(1.0));
}

namespace {

/// Six submaps of one block each, four metres apart along x.
struct Row {
  SubmapShelf shelf{std::make_unique<tests::MemoryPageFile>()};
  VoxelMap view{Grid{0.05F}, {64, 64, 64}};
  SubmapChain chain{view, {}, &shelf};

  static VoxelIndex place(int i) { return {32768 + 80 * i, 32768, 32768}; }
  Row() {
    BlockValues values;
    for (int i = 0; i < 6; ++i) {
      values.fill(static_cast<Rgbo>(20 + i));
      REQUIRE(view.write_block(block_of(place(i)), values));
      chain.add_frame(i, {}, std::array{view.find(block_of(place(i)))});
      REQUIRE(chain.finish_submap());
    }
  }
  [[nodiscard]] std::vector<bool> in_memory() const {
    std::vector<bool> are;
    for (const Submap& submap : chain.submaps()) are.push_back(submap.contents->is_in_memory());
    return are;
  }
};

}  // namespace

TEST_CASE("submaps that have nothing near the camera go to the shelf, and come back when asked") {
  Row row;
  CHECK(row.chain.in_memory() == 6);
  const std::uint64_t all_bytes = row.chain.memory_bytes();
  // Regions are 3.2 m long: from the third submap's to those beside it.
  row.chain.put_away_far(Row::place(2), 80);
  CHECK(row.in_memory() == std::vector<bool>{false, true, true, true, false, false});
  CHECK(row.chain.in_memory() == 3);
  CHECK(row.chain.memory_bytes() < all_bytes);
  CHECK(hash_of(row.chain, row.view) == map_hash(row.view));
  CHECK(row.chain.in_memory() == 6);
}

TEST_CASE("of submaps in memory those stay that were used last") {
  Row row;
  BlockValues values;
  for (const int i : {5, 0, 3}) REQUIRE(row.chain.read_block(block_of(Row::place(i)), values));
  row.chain.put_away_all_but(6);
  CHECK(row.chain.in_memory() == 6);
  row.chain.put_away_all_but(2);
  CHECK(row.in_memory() == std::vector<bool>{true, false, false, true, false, false});
  row.chain.put_away_all_but(0);
  CHECK(row.chain.in_memory() == 0);
  CHECK(row.shelf.counts().put_away == 6);
}

TEST_CASE("only the regions that somebody wants are made anew") {
  Row row;
  row.chain.put_away_all_but(0);
  const auto is_wanted = [](RegionKey region) { return region == region_of(Row::place(1)); };
  row.chain.place(std::vector<hal::Pose>(6, hal::from_xyz_rpy(-4.0, 0.0, 0.0, 0.0, 0.0, 0.0)));
  row.chain.rebuild(is_wanted);
  CHECK(row.view.block_count() == 1);
  CHECK(level_of(row.view.at(Row::place(1))) == 22);
  CHECK(row.chain.in_memory() == 1);  // no other was needed for it
}
