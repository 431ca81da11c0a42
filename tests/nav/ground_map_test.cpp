// SPDX-License-Identifier: Apache-2.0
#include "nav/ground_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "mapper/mapper.hpp"
#include "tests/support/emulated_mapper.hpp"
#include "tests/support/plain_ground.hpp"
#include "tests/support/sample_maps.hpp"
#include "tests/support/voxel_floor.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::nav;
using mapper::VoxelMap;

namespace {

constexpr mapper::MapCapacity kSmall{1U << 12, 1U << 12, 1U << 10};

GroundMapConfig small_config(double side_m) {
  GroundMapConfig config;
  config.side_m = side_m;
  config.max_slots = 1U << 16;
  return config;
}

/// A map that is written voxel by voxel, and the ground map that follows it.
struct Bench {
  explicit Bench(float resolution_m = 0.05F)
      : map(mapper::Grid{resolution_m}, kSmall), ground(map.grid(), small_config(6.4)) {}

  void set(double x_m, double y_m, double z_m, std::uint8_t level) {
    const auto at = map.grid().to_index(static_cast<float>(x_m), static_cast<float>(y_m), static_cast<float>(z_m));
    mapper::BlockValues values;
    map.read_block(mapper::block_of(at), values);
    values[mapper::encode(at) & mapper::kPlaceMask] = level;
    REQUIRE(map.write_block(mapper::block_of(at), values));
    const std::array<std::uint32_t, 1> slot{map.find(mapper::block_of(at))};
    ground.update(map, slot);
  }
  void floor(double x_m, double y_m) { set(x_m, y_m, -0.001, 28); }
  [[nodiscard]] CellState at(double x_m, double y_m) const {
    return ground.states().at(ground.states().cell_of(x_m, y_m));
  }

  VoxelMap map;
  GroundMap ground;
};

}  // namespace

TEST_CASE("The ground map is what a computation from scratch gives, whatever happens to blocks") {
  for (const float resolution_m : {0.05F, 0.02F, 0.01F}) {
    const GroundMapConfig config = small_config(40.0 * static_cast<double>(resolution_m));
    VoxelMap map({resolution_m}, kSmall);
    GroundMap ground(map.grid(), config);
    CellGrid<CellState> followed = ground.states();
    tests::Random random(11);
    std::array<std::uint64_t, 3> seen{};
    for (int step = 0; step < 60; ++step) {
      std::vector<std::uint32_t> slots;
      for (std::uint32_t n = 1 + random.below(6); n > 0; --n) {
        const auto near = [&](std::int32_t middle, std::uint32_t spread) {
          return middle - static_cast<std::int32_t>(spread / 2) + static_cast<std::int32_t>(random.below(spread));
        };
        const mapper::BlockKey key = mapper::encode({near(4096, 7), near(4096, 7), near(4097, 10)});
        const std::uint32_t old_slot = map.find(key);
        if (old_slot != mapper::kNoSlot && random.below(4) == 0) {
          REQUIRE(map.erase_block(key));
          ground.update(map, {&old_slot, 1});  // its slot may soon be another block's
          for (const std::uint32_t i : ground.changed_cells()) followed.cells[i] = ground.states().cells[i];
          continue;
        }
        mapper::BlockValues values;
        const std::uint32_t kind = random.below(4);
        const auto base = static_cast<std::uint8_t>(random.below(33));
        for (mapper::Rgbo& value : values) {
          const std::uint32_t odd = kind == 0 ? 1 : kind == 1 ? 8 : 300;
          value = random.below(odd) == 0 ? random.below(33) : kind == 3 ? base : 14 + 2 * (base % 2);
        }
        REQUIRE(map.write_block(key, values));
        slots.push_back(map.find(key));
      }
      ground.update(map, slots);
      REQUIRE(ground.states().cells == tests::plain_ground(map, ground.states(), config).cells);
      GroundMap fresh(map.grid(), config);
      fresh.rebuild(map);
      REQUIRE(fresh.states().cells == ground.states().cells);
      for (const std::uint32_t i : ground.changed_cells()) followed.cells[i] = ground.states().cells[i];
      REQUIRE(followed.cells == ground.states().cells);  // whoever follows the changes knows everything
      for (const CellState state : ground.states().cells) ++seen[static_cast<std::size_t>(state)];
    }
    CHECK(*std::min_element(seen.begin(), seen.end()) > 100);
  }
}

TEST_CASE("On a simulated drive the ground map is at every frame what it would be from scratch") {
  const test::Workload drive = test::simulated_drive("furnished_room", 60, 0.5, 0.0, 160);
  REQUIRE(drive.frames.size() == 60);
  mapper::MapperConfig mapper_config;
  mapper_config.capacity = {1U << 14, 1U << 13, 1U << 10};
  mapper::Mapper mapper(mapper_config, drive.camera);
  const GroundMapConfig config = small_config(16.0);
  GroundMap ground(mapper.map().grid(), config);
  std::size_t floor_seen = 0;
  int frame = 0;
  for (const test::PosedImage& image : drive.frames) {
    mapper.integrate(image.frame, image.T_world_camera);
    ground.update(mapper.map(), mapper.changed_slots());
    GroundMap fresh(mapper.map().grid(), config);
    fresh.rebuild(mapper.map());
    REQUIRE(fresh.states().cells == ground.states().cells);
    if (++frame % 10 != 0) continue;
    REQUIRE(ground.states().cells == tests::plain_ground(mapper.map(), ground.states(), config).cells);
  }
  const auto& cells = ground.states().cells;
  for (std::size_t i = 0; i < cells.size(); ++i) floor_seen += ground.is_floor_seen(ground.states().cell(i)) ? 1 : 0;
  CHECK(std::count(cells.begin(), cells.end(), CellState::free) > 15000);  // of 100 m2 = 40000 cells
  CHECK(std::count(cells.begin(), cells.end(), CellState::occupied) > 1000);
  CHECK(floor_seen > 12000);
}

TEST_CASE("Floor is free, a wall is not, and air alone is a presumption") {
  Bench bench;
  CHECK(bench.at(0.52, 0.52) == CellState::unknown);
  bench.floor(0.52, 0.52);
  CHECK(bench.at(0.52, 0.52) == CellState::free);
  CHECK(bench.ground.is_floor_seen(bench.ground.states().cell_of(0.52, 0.52)));
  bench.set(0.52, 0.52, 0.3, 28);
  CHECK(bench.at(0.52, 0.52) == CellState::occupied);
  bench.set(0.52, 0.52, 0.3, 4);
  CHECK(bench.at(0.52, 0.52) == CellState::free);

  bench.set(1.02, 0.52, 0.42, 4);
  CHECK(bench.at(1.02, 0.52) == CellState::free);
  CHECK_FALSE(bench.ground.is_floor_seen(bench.ground.states().cell_of(1.02, 0.52)));
  bench.set(1.52, 0.52, 0.52, 4);  // seen over the top of a chest of drawers, perhaps
  CHECK(bench.at(1.52, 0.52) == CellState::unknown);
  bench.set(1.77, 0.52, 0.7, 28);  // above the robot
  CHECK(bench.at(1.77, 0.52) == CellState::unknown);
  CHECK_FALSE(bench.ground.is_floor_seen({-1, 5}));
}

TEST_CASE("Whoever looks through close above the ground sees the floor, or believes nothing") {
  Bench bench;
  bench.set(1.02, 0.52, 0.3, 4);
  bench.set(1.02, 0.52, 0.08, 4);  // through a wall that was too near to be measured
  CHECK(bench.at(1.02, 0.52) == CellState::unknown);
  bench.floor(1.32, 0.52);  // just beyond it there is floor: the ray over this cell ended there
  CHECK(bench.at(1.02, 0.52) == CellState::free);
  bench.set(1.32, 0.52, -0.001, 14);
  CHECK(bench.at(1.02, 0.52) == CellState::unknown);
  bench.floor(1.37, 0.52);  // farther than the margin
  CHECK(bench.at(1.02, 0.52) == CellState::unknown);
}

TEST_CASE("A step is an obstacle at resolutions that can tell it from the floor") {
  for (const float resolution_m : {0.01F, 0.02F}) {
    Bench bench(resolution_m);
    bench.floor(0.51, 0.51);
    bench.set(0.51, 0.51, 0.012, 28);
    CHECK(bench.at(0.51, 0.51) == CellState::free);  // a carpet
    bench.set(0.51, 0.51, 0.035, 28);
    CHECK(bench.at(0.51, 0.51) == CellState::occupied);
  }
}

TEST_CASE("A speckle is no obstacle, whatever is hit twice is") {
  Bench bench;
  bench.floor(0.52, 0.52);
  bench.set(0.52, 0.52, 0.3, 20);
  CHECK(bench.at(0.52, 0.52) == CellState::free);
  bench.set(0.52, 0.52, 0.3, 24);  // the next frame confirms it
  CHECK(bench.at(0.52, 0.52) == CellState::occupied);
  bench.set(0.52, 0.52, 0.3, 15);
  CHECK(bench.at(0.52, 0.52) == CellState::free);
  bench.set(0.52, 0.52, 0.3, 20);
  bench.set(0.52, 0.52, 0.4, 20);  // a pole, in its first frame
  CHECK(bench.at(0.52, 0.52) == CellState::occupied);
  bench.set(1.02, 1.02, 0.1, 20);
  CHECK(bench.at(1.02, 1.02) == CellState::unknown);
  bench.set(1.07, 1.07, 0.1, 20);  // a low box, in its first frame: its neighbour was hit, too
  CHECK(bench.at(1.02, 1.02) == CellState::occupied);
  CHECK(bench.at(1.07, 1.07) == CellState::occupied);
  bench.set(1.07, 1.07, 0.1, 14);
  CHECK(bench.at(1.02, 1.02) == CellState::unknown);
}

TEST_CASE("Beyond a drop nothing is drivable, up to the floor that was seen") {
  Bench bench;
  for (double x = 0.025; x < 1.0; x += 0.05) bench.floor(x, 0.52);
  for (double x = 1.025; x < 1.8; x += 0.05) bench.set(x, 0.52, 0.2, 4);  // air above the edge and beyond
  CHECK(bench.at(1.03, 0.52) == CellState::free);                         // so far nothing speaks against it
  bench.set(1.23, 0.52, -0.07, 4);                                        // seen down there
  CHECK(bench.at(1.23, 0.52) == CellState::occupied);
  CHECK(bench.ground.is_drop(bench.ground.states().cell_of(1.23, 0.52)));
  CHECK(bench.at(1.03, 0.52) == CellState::occupied);
  CHECK(bench.at(0.98, 0.52) == CellState::free);  // floor
  CHECK(bench.at(1.68, 0.52) == CellState::free);  // farther than the margin
  bench.floor(1.23, 0.52);                         // it was an artefact: floor it is
  CHECK(bench.at(1.23, 0.52) == CellState::free);
  CHECK(bench.at(1.03, 0.52) == CellState::free);
}

TEST_CASE("The start is free, until something is measured there") {
  Bench bench;
  bench.ground.mark_free_disc(0.5, 0.5, 0.2);
  CHECK(bench.at(0.5, 0.5) == CellState::free);
  CHECK(bench.at(0.66, 0.5) == CellState::free);
  CHECK(bench.at(0.72, 0.5) == CellState::unknown);
  const std::size_t marked = bench.ground.changed_cells().size();
  CHECK(marked == 52);  // pi 0.2^2 / 0.05^2 = 50
  bench.floor(2.02, 0.52);
  CHECK(bench.ground.changed_cells().size() == marked + 1);  // what was marked before an update counts to it
  bench.set(0.52, 0.52, 0.2, 28);
  CHECK(bench.at(0.52, 0.52) == CellState::occupied);
  CHECK(bench.ground.changed_cells().size() == 1);
}

TEST_CASE("A contact stays where the camera had seen a free floor, and goes where it had not looked yet") {
  Bench bench;
  for (double x = 0.025; x < 0.5; x += 0.05) bench.floor(x, 0.525);
  bench.ground.mark_contact(0.425, 0.525, 0.03);  // glass: the camera saw through it
  CHECK(bench.at(0.425, 0.525) == CellState::occupied);
  CHECK(bench.at(0.375, 0.525) == CellState::free);
  bench.set(0.425, 0.525, 0.2, 4);
  CHECK(bench.at(0.425, 0.525) == CellState::occupied);

  bench.ground.mark_contact(1.025, 0.525, 0.03);  // something low beside the start, never in view
  CHECK(bench.at(1.025, 0.525) == CellState::occupied);
  bench.set(1.025, 0.525, 0.4, 4);  // air above it says nothing
  CHECK(bench.at(1.025, 0.525) == CellState::occupied);
  bench.floor(1.025, 0.525);  // it was a person's foot
  CHECK(bench.at(1.025, 0.525) == CellState::free);
  bench.ground.mark_contact(1.025, 0.525, 0.03);  // no: bumped into again
  CHECK(bench.at(1.025, 0.525) == CellState::occupied);

  bench.ground.forget_contacts();
  CHECK(bench.at(0.425, 0.525) == CellState::free);
  CHECK(bench.at(1.025, 0.525) == CellState::free);
}

TEST_CASE("What was paged out stays known, even where its neighbour above changes") {
  Bench bench;
  bench.floor(0.52, 0.52);
  const mapper::BlockKey floor_block = mapper::block_of(bench.map.grid().to_index(0.52F, 0.52F, -0.001F));
  REQUIRE(bench.map.erase_block(floor_block));  // a window does so without a word
  bench.set(2.02, 2.02, 0.2, 28);               // takes its slot
  CHECK(bench.at(0.52, 0.52) == CellState::free);
  bench.set(0.52, 0.52, 0.2, 4);
  CHECK(bench.ground.is_floor_seen(bench.ground.states().cell_of(0.52, 0.52)));
  bench.set(0.52, 0.52, 0.2, 28);
  CHECK(bench.at(0.52, 0.52) == CellState::occupied);
  const std::uint32_t slot = bench.map.find(mapper::block_of(bench.map.grid().to_index(0.52F, 0.52F, 0.2F)));
  REQUIRE(bench.map.erase_block(mapper::block_of(bench.map.grid().to_index(0.52F, 0.52F, 0.2F))));
  bench.ground.update(bench.map, {&slot, 1});  // this one is really gone
  CHECK(bench.at(0.52, 0.52) == CellState::free);
  bench.ground.rebuild(bench.map);  // memory alone counts now
  CHECK(bench.at(0.52, 0.52) == CellState::unknown);
  CHECK(bench.at(2.02, 2.02) == CellState::occupied);
}

TEST_CASE("Blocks outside of the square are nobody's business") {
  Bench bench;
  bench.set(3.3, 0.5, 0.2, 28);
  bench.set(-40.0, 900.0, 0.2, 28);
  CHECK(bench.ground.changed_cells().empty());
  CHECK(bench.ground.states().columns == 128);
  CHECK(bench.ground.states().origin_x_m == Approx(-3.2));
  bench.set(3.17, -3.17, 0.2, 28);
  CHECK(bench.at(3.17, -3.17) == CellState::occupied);
}

TEST_CASE("The square lies around the start, on whole blocks") {
  GroundMapConfig config = small_config(10.0);
  config.centre_x_m = 21.3;
  config.centre_y_m = -7.9;
  const GroundMap ground({0.02F}, config);
  const auto& states = ground.states();
  CHECK(states.resolution_m == Approx(0.04));
  CHECK(states.columns * 0.04 == Approx(10.08));
  CHECK(std::abs(states.origin_x_m + 5.04 - 21.3) < 0.09);
  CHECK(std::abs(states.origin_y_m + 5.04 + 7.9) < 0.09);
}

TEST_CASE("A step is occupied, whatever the voxels say, until it is none any more") {
  tests::VoxelFloor voxels({-3, -3, 4, 3});
  nav::GroundMapConfig config;
  config.side_m = 12.8;
  nav::GroundMap ground(voxels.map().grid(), config);
  voxels.look(tests::KinematicRobot({}, {}));
  ground.update(voxels.map(), voxels.changed_slots());
  const nav::Cell c = ground.states().cell_of(1.52, 0.01);
  REQUIRE(ground.states().at(c) == nav::CellState::free);
  ground.mark_step(c, true);
  CHECK(ground.states().at(c) == nav::CellState::occupied);
  CHECK(ground.changed_cells().back() == ground.states().index(c));
  ground.forget_contacts();
  CHECK(ground.states().at(c) == nav::CellState::occupied);
  ground.mark_step(c, false);
  CHECK(ground.states().at(c) == nav::CellState::free);
  ground.mark_step({-1, 0}, true);  // outside: nothing
}

TEST_CASE("what a card reads of columns gives the ground map that the voxels give, and losses are noticed all the same",
          "[cuda]") {
  for (const float resolution_m : {0.05F, 0.02F}) {
    const test::Workload work = test::simulated_drive("furnished_room", 5, 0.4, 3.0, 160);
    mapper::MapperConfig config;
    config.resolution_m = resolution_m;
    config.capacity = {1U << 16, 1U << 15, 1U << 15};
    test::EmulatedMapper emulated(config, work.camera, 5);
    GroundMap from_voxels(emulated.map.grid(), small_config(12.8));
    GroundMap from_card(emulated.map.grid(), small_config(12.8));
    emulated.twin.follow_columns(from_card.column_tables());
    std::uint32_t number = 0;
    std::size_t known = 0;
    for (const auto& [frame, pose] : work.frames) {
      mapper::FrameReport report;
      const auto geometry = mapper::cpu::frame_geometry(emulated.sensor, hal::to_transform(pose));
      REQUIRE(geometry);
      REQUIRE(emulated.twin.begin(frame, *geometry, true, ++number, report));
      from_card.update(emulated.twin.changed_columns());  // the map is still the frame before
      REQUIRE(emulated.twin.finish(report));
      from_card.note_slots(emulated.map, emulated.twin.changed_slots());
      from_voxels.update(emulated.map, emulated.twin.changed_slots());
      CHECK(from_card.states().cells == from_voxels.states().cells);
      CHECK(std::equal(from_card.changed_cells().begin(), from_card.changed_cells().end(),
                       from_voxels.changed_cells().begin(), from_voxels.changed_cells().end()));
      known += from_card.changed_cells().size();
      // A block is forgotten, and both are told the slot where it was.
      const auto slots = emulated.twin.changed_slots();
      const std::array<std::uint32_t, 1> lost{slots[slots.size() / 2]};
      REQUIRE(emulated.map.erase_block(emulated.map.header(lost[0]).key));
      from_card.update(emulated.map, lost);
      from_voxels.update(emulated.map, lost);
      CHECK(from_card.states().cells == from_voxels.states().cells);
    }
    CHECK(known > 1000);
  }
}
