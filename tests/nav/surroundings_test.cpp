// SPDX-License-Identifier: Apache-2.0
#include "nav/surroundings.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"
#include "mapper/mapper.hpp"
#include "tests/support/voxel_floor.hpp"

using namespace g3d;
using nav::CellState;
using tests::Box;

namespace {

struct Scene {
  tests::KinematicRobot robot;
  tests::VoxelFloor floor{{-3, -3, 4, 3}};
  nav::Surroundings here;

  explicit Scene(const std::vector<Box>& boxes) : robot(boxes, {}), here(floor.map().grid(), config()) {}
  static nav::SurroundingsConfig config() {
    nav::SurroundingsConfig c;
    c.ground.side_m = 12.8;
    return c;
  }
  void look(hal::TimeNs now = 0) {
    here.on_pose(robot.pose(), now);
    floor.look(robot);
    here.on_map(floor.map(), floor.changed_slots(), robot.pose());
  }
  [[nodiscard]] nav::Cell cell(double x_m, double y_m) const { return here.states().cell_of(x_m, y_m); }
};

}  // namespace

TEST_CASE("Floor, walls and costs come from the voxels, and every changed cell is named once") {
  Scene scene({{2.0, -3, 2.2, 3}});
  scene.look();
  CHECK(scene.here.states().at(scene.cell(1.5, 0.0)) == CellState::free);
  CHECK(scene.here.states().at(scene.cell(2.02, 0.0)) == CellState::occupied);
  CHECK(scene.here.states().at(scene.cell(-1.5, 0.0)) == CellState::unknown);
  CHECK(scene.here.cost().at(scene.cell(1.95, 0.0)) == nav::kInscribedCost);
  CHECK(scene.here.cost().at(scene.cell(1.2, 0.0)) == nav::kFreeCost);
  std::vector<std::uint32_t> changed(scene.here.changed_cells().begin(), scene.here.changed_cells().end());
  std::sort(changed.begin(), changed.end());
  CHECK(std::adjacent_find(changed.begin(), changed.end()) == changed.end());
  for (std::size_t i = 0; i < scene.here.states().cells.size(); ++i) {
    if (scene.here.states().cells[i] == CellState::unknown && scene.here.cost().cells[i] == nav::kUnknownCost) continue;
    REQUIRE(std::binary_search(changed.begin(), changed.end(), static_cast<std::uint32_t>(i)));
  }
  scene.here.forget_changes();
  CHECK(scene.here.changed_cells().empty());
}

TEST_CASE("Seen is where the floor was, where the camera looked low, and where the body was") {
  Scene scene({});
  scene.look();
  CHECK(scene.here.is_seen(scene.cell(1.5, 0.0)));
  CHECK(scene.here.is_seen(scene.cell(0.9, 0.0)));
  CHECK(scene.here.is_seen(scene.cell(0.1, 0.0)));
  CHECK_FALSE(scene.here.is_seen(scene.cell(0.5, 0.0)));
  CHECK_FALSE(scene.here.is_seen(scene.cell(-0.5, 0.0)));
}

TEST_CASE("A touch closes the place, makes what is around it doubtful, and can be forgotten") {
  Scene scene({});
  scene.look();
  const nav::Cell touched = scene.cell(0.21, 0.0);
  scene.here.on_touch({}, 0.0);
  CHECK(scene.here.states().at(touched) == CellState::occupied);
  CHECK(scene.here.cost().at(scene.cell(0.32, 0.0)) >= nav::kInscribedCost);
  CHECK_FALSE(scene.here.is_seen(scene.cell(0.85, 0.0)));
  CHECK(scene.here.is_seen(scene.cell(1.2, 0.0)));
  CHECK(scene.here.is_seen(scene.cell(-0.1, 0.0)));  // the body stands there
  scene.here.forget_touches();
  CHECK(scene.here.states().at(touched) == CellState::free);
  CHECK(scene.here.is_seen(scene.cell(0.85, 0.0)));
}

TEST_CASE("Between two touches that are near each other there is no way through") {
  Scene scene({});
  scene.look();
  scene.here.on_touch({0.8, -0.3, 0.0}, 0.0);
  CHECK(scene.here.states().at(scene.cell(1.01, 0.0)) == CellState::free);
  scene.here.on_touch({0.8, 0.3, 0.0}, 0.0);
  for (double y = -0.3; y <= 0.3; y += 0.04) {
    CHECK(scene.here.states().at(scene.cell(1.01, y)) == CellState::occupied);
  }
  scene.here.on_touch({2.5, 0.0, 0.0}, 0.0);  // another thing
  CHECK(scene.here.states().at(scene.cell(1.9, 0.0)) == CellState::free);
}

TEST_CASE("What stays suspect is closed for planning until it is reopened; touches stay closed") {
  Scene scene({});
  scene.look();
  hal::CameraModel camera;
  camera.width_px = 160;
  camera.height_px = 120;
  camera.fx_px = camera.fy_px = 131.25F;
  camera.cx_px = 79.5F;
  camera.cy_px = 59.5F;
  const hal::Frame dark = hal::make_frame(camera);
  CHECK_FALSE(scene.here.reopen());
  scene.here.on_touch({2.0, 0.0, 0.0}, 0.0);
  scene.here.on_frame(dark, camera, {}, 0);
  CHECK(scene.here.is_suspect(scene.cell(0.5, 0.0)));
  CHECK(scene.here.cost().at(scene.cell(0.65, 0.0)) < nav::kInscribedCost);
  scene.here.close_suspects();
  CHECK(scene.here.cost().at(scene.cell(0.65, 0.0)) == nav::kLethalCost);
  CHECK(scene.here.reopen());
  CHECK(scene.here.cost().at(scene.cell(0.65, 0.0)) < nav::kInscribedCost);
  CHECK(scene.here.states().at(scene.cell(2.21, 0.0)) == CellState::occupied);
}

TEST_CASE("The own way stays open whoever stands in it, at a price") {
  Scene scene({});
  scene.look();
  scene.here.on_pose({0.5, 0.0, 0.0}, 0);
  scene.here.on_touch({0.25, 0.0, 0.0}, 0.0);  // right there
  const nav::Cell there = scene.cell(0.45, 0.0);
  REQUIRE(scene.here.cost().at(there) >= nav::kInscribedCost);
  CHECK(scene.here.cost_of_own_way().at(there) < nav::kInscribedCost);
  CHECK(scene.here.cost_of_own_way().at(there) > 200);
  CHECK(scene.here.cost_of_own_way().at(scene.cell(1.5, 0.0)) == scene.here.cost().at(scene.cell(1.5, 0.0)));
}

TEST_CASE("A robot that is cut off may trust its own way, and goals are chosen by it, too") {
  Scene scene({});
  scene.look();
  scene.here.on_pose({0.51, 0.01, 0.0}, 0);
  scene.here.on_touch({0.25, 0.0, 0.0}, 0.0);
  const nav::Cell there = scene.cell(0.51, 0.01);
  REQUIRE(scene.here.cost().at(there) == nav::kInscribedCost);
  scene.here.forget_changes();
  CHECK(scene.here.trust_own_way());
  CHECK(scene.here.cost().at(there) == nav::TightPlaces::kTightCost);
  const auto changed = scene.here.changed_cells();
  CHECK(std::find(changed.begin(), changed.end(), scene.here.cost().index(there)) != changed.end());
  CHECK_FALSE(scene.here.trust_own_way());
}

TEST_CASE("Noise at the rim of a trusted way is not in the way, what stands in its middle is") {
  Scene scene({});
  scene.look();
  for (int i = 0; i < 40; ++i) scene.here.on_pose({0.01 + 0.02 * i, 0.025, 0.0}, 0);
  const nav::Cell middle = scene.cell(0.4, 0.02);
  const nav::Cell rim = scene.cell(0.4, 0.18);
  const nav::Cell beside = scene.cell(0.4, 0.23);
  const nav::Cell beyond = scene.cell(0.4, 0.33);
  for (const nav::Cell c : {middle, rim, beside, beyond}) CHECK(scene.here.extent(c) == nav::Extent::square);
  (void)scene.here.trust_own_way();
  CHECK(scene.here.extent(middle) == nav::Extent::square);
  CHECK(scene.here.extent(rim) == nav::Extent::nothing);
  CHECK(scene.here.extent(beside) == nav::Extent::middle);
  CHECK(scene.here.extent(beyond) == nav::Extent::square);
  scene.here.on_touch({0.3, 0.4, 0.0}, 0.0);  // what was touched nearby is whole
  CHECK(scene.here.extent(rim) == nav::Extent::square);
}

TEST_CASE("Planning leaves room for the body wherever it is in its cell") {
  CHECK(nav::planning_radius_m(0.18, 0.05) > 0.18 + 0.025);
  CHECK(nav::planning_radius_m(0.18, 0.05) < 0.225);  // five cells from an obstacle's centre it fits
}

TEST_CASE("Somebody who walks across is in the way long before the map knows him", "[nav][surroundings][slow]") {
  // He comes from the left at a metre per second, 1.5 m before a robot that stands, and is gone again after 6 s.
  hal::SimBuildingOptions options;
  options.camera = hal::scaled_kinect(160, 120);
  options.robots.emplace_back();
  hal::SimBuilding building(
      hal::parse_world("floor 0 0 0 16 16 0.1\nbox 3 0 0 0.2 8 2\nperson 1.8 0.2  0,1.7,3 6,1.7,-3\n", "w").value(),
      options);
  mapper::Mapper mapper({}, options.camera, {});
  nav::SurroundingsConfig config;
  config.ground.side_m = 12.8;
  nav::Surroundings here(mapper.map().grid(), config);
  hal::Frame frame = hal::make_frame(options.camera);
  nav::ArcCheck arc(0.178, 0.01, 1.6, 0.05);
  constexpr double kEmpty_m = 1.5;  // free ahead at least, where nobody is
  int in_the_way = 0, noticed = 0, in_map = 0;
  for (hal::TimeNs now = 0; now < 7'000'000'000; now += 100'000'000) {
    building.advance_to(now);
    building.render(0, frame);
    frame.stamp_ns = now;
    here.on_pose({}, now);
    (void)mapper.integrate(frame, building.T_world_camera(0));
    here.on_map(mapper.map(), mapper.changed_slots(), {});
    here.on_frame(frame, options.camera, {}, now);
    if (std::fabs(building.mover_places_m()[0][1]) > 0.3F) continue;
    ++in_the_way;
    arc.gather(here.states(), {}, &here);
    noticed += arc.look(0.0, 1.55).clear_m < kEmpty_m ? 1 : 0;
    arc.gather(here.states(), {});
    in_map += arc.look(0.0, 1.55).clear_m < kEmpty_m ? 1 : 0;
  }
  CHECK(in_the_way >= 5);
  CHECK(noticed == in_the_way);
  CHECK(in_map < in_the_way);
  arc.gather(here.states(), {}, &here);
  CHECK(arc.look(0.0, 1.55).clear_m > kEmpty_m);  // and nobody is remembered where the camera has looked through since
}

namespace {

/// A map in which everything stands one block farther in x, as a part of it at a time would be moved.
struct ShiftedMap {
  explicit ShiftedMap(const mapper::VoxelMap& from) : map(from.grid(), from.capacity()) {
    mapper::BlockValues values;
    for (const mapper::BlockKey key : from.sorted_keys()) {
      (void)from.read_stored_block(key, values);
      REQUIRE(map.write_block(key, values));
    }
  }
  /// Returns the slots that are empty now.
  std::vector<std::uint32_t> take_away() {
    std::vector<std::uint32_t> slots;
    for (const mapper::BlockKey key : map.sorted_keys()) {
      mapper::BlockValues values;
      (void)map.read_stored_block(key, values);
      const mapper::VoxelIndex v = mapper::block_origin(key);
      blocks.push_back({mapper::block_of({v.x + mapper::kBlockSide_cells, v.y, v.z}), values});
      slots.push_back(map.find(key));
      map.erase_block(key);
    }
    return slots;
  }
  /// Returns the slots that are full now.
  std::vector<std::uint32_t> put_down() {
    std::vector<std::uint32_t> slots;
    for (const auto& [key, values] : blocks) {
      REQUIRE(map.write_block(key, values));
      slots.push_back(map.find(key));
    }
    return slots;
  }
  mapper::VoxelMap map;
  std::vector<std::pair<mapper::BlockKey, mapper::BlockValues>> blocks;
};

constexpr double kBlock_m = 0.4;

}  // namespace

TEST_CASE("After the map has moved everything is as if it had always been there", "[nav][surroundings]") {
  Scene scene({{2.0, -3, 2.2, 3}});
  Scene elsewhere({});  // whose robot stands where the first one's map goes
  const auto at = [](double x_m, double y_m, double heading_rad) { return hal::PlanarPose{x_m, y_m, heading_rad}; };
  scene.look(1);
  // A touch, floor that only the body knows, and a way.
  for (int i = 0; i < 12; ++i) {
    scene.here.on_pose(at(0.05 * i, 0.0, 0.0), 2 + i);
    elsewhere.here.on_pose(at(0.05 * i + kBlock_m, 0.0, 0.0), 2 + i);
  }
  scene.here.on_touch(at(0.55, 0.0, 0.0), 0.0);
  ShiftedMap shifted(scene.floor.map());
  elsewhere.here.on_pose(at(0.55 + kBlock_m, 0.0, 0.0), 20);

  ShiftedMap target(scene.floor.map());
  (void)target.take_away();
  (void)target.put_down();
  const auto all_of = [](const mapper::VoxelMap& map) {
    std::vector<std::uint32_t> slots;
    for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) slots.push_back(slot);
    return slots;
  };
  elsewhere.here.on_map(target.map, all_of(target.map), at(0.55 + kBlock_m, 0.0, 0.0));
  elsewhere.here.on_touch(at(0.55 + kBlock_m, 0.0, 0.0), 0.0);

  scene.here.on_map(shifted.map, all_of(shifted.map), at(0.55, 0.0, 0.0));  // the copy has slots of its own
  scene.here.begin_to_move();
  const auto gone = shifted.take_away();
  scene.here.on_map(shifted.map, gone, at(0.55, 0.0, 0.0));
  const auto come = shifted.put_down();
  scene.here.on_map(shifted.map, come, at(0.55, 0.0, 0.0));
  scene.here.move(mapper::submaps::ChainMove({0}, {hal::from_xyz_rpy(kBlock_m, 0, 0, 0, 0, 0)}));

  const auto& states = scene.here.states();
  for (std::size_t i = 0; i < states.cells.size(); ++i) {
    const nav::Cell c = states.cell(i);
    INFO(states.centre_x_m(c) << " " << states.centre_y_m(c));
    REQUIRE(states.cells[i] == elsewhere.here.states().cells[i]);
    REQUIRE(scene.here.cost().cells[i] == elsewhere.here.cost().cells[i]);
    REQUIRE(scene.here.is_suspect(c) == elsewhere.here.is_suspect(c));
  }
  CHECK(states.at(scene.cell(2.42, 0.0)) == CellState::occupied);
  CHECK(scene.here.is_seen(scene.cell(0.9, 0.0)));
  // Nobody has come: these walls stood there all the time.
  CHECK_FALSE(scene.here.is_unwatched(scene.cell(2.42, 0.0)));
}
