// SPDX-License-Identifier: Apache-2.0
// Robots that were told wrongly where they start: once they have shared their maps, these fit.
#include "net/pose_refiner.hpp"

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "mapper/align/pose_step.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "net/layer_writer.hpp"
#include "net/merged_map.hpp"
#include "tests/support/gossip_fleet.hpp"
#include "tests/support/map_agreement.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;
using tests::GossipFleet;

namespace {

constexpr hal::TimeNs kRefineSecond_ns = 1'000'000'000;
constexpr double kRefineDegree = std::numbers::pi / 180.0;
const mapper::MapCapacity kRefineRoom{1U << 13, 1U << 13, 1U << 14};

/// What a robot has seen of a map, in a frame of its own.
std::unique_ptr<mapper::VoxelMap> what_is_seen_of(const mapper::VoxelMap& map, const hal::Pose& T_world_own,
                                                  const std::function<bool(const std::array<double, 3>&)>& has_seen) {
  mapper::VoxelMap part(map.grid(), map.capacity());
  mapper::BlockValues values;
  for (const mapper::BlockKey key : map.sorted_keys()) {
    map.read_stored_block(key, values);
    const mapper::VoxelIndex origin = mapper::block_origin(key);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const mapper::VoxelIndex p = mapper::decode(i);
      const auto at = map.grid().centre_m(mapper::VoxelIndex{origin.x + p.x, origin.y + p.y, origin.z + p.z});
      if (!has_seen(at)) values[i] = mapper::kUnknownRgbo;
    }
    REQUIRE(part.write_block(key, values));
  }
  const std::array<mapper::MergeSource, 1> source{mapper::MergeSource{&part, hal::inverse(T_world_own), 0}};
  mapper::MergeOptions options;
  options.capacity = kRefineRoom;
  return std::move(mapper::merge_maps(source, options)).value();
}

struct RefinedRobot {
  std::unique_ptr<mapper::VoxelMap> map;
  hal::Pose T_world_map;  ///< where it is
  hal::Pose T_world_said;
};

class RefinedFleet {
 public:
  explicit RefinedFleet(std::vector<RefinedRobot> robots)
      : robots_(std::move(robots)), fleet_(options(robots_.size())) {
    for (std::uint32_t i = 0; i < robots_.size(); ++i) {
      const RefinedRobot& robot = robots_[i];
      writers_.push_back(std::make_unique<net::LayerWriter>(*robot.map, fleet_.gossip(i), fleet_.store(i)));
      REQUIRE(writers_[i]->publish_pose(robot.T_world_said, fleet_.now_ns()));
      for (std::uint32_t slot = 0; slot < robot.map->slot_end(); ++slot) writers_[i]->note_changed(std::array{slot});
      net::RefinerOptions refining;
      refining.grid = robot.map->grid();
      refining.map = kRefineRoom;
      refining.is_lockstep = true;
      refiners_.push_back(std::make_unique<net::PoseRefiner>(refining, fleet_.store(i), fleet_.gossip(i).own_layer(),
                                                             robot.T_world_said));
    }
  }
  void run(int seconds) {
    for (int step = 0; step < 10 * seconds; ++step) {
      for (std::uint32_t i = 0; i < robots_.size(); ++i) {
        (void)writers_[i]->publish_round(20000, fleet_.now_ns());
        const auto placed = refiners_[i]->on_time(fleet_.now_ns());
        if (!placed) continue;
        ++published_;
        REQUIRE(writers_[i]->publish_placement(*placed, fleet_.now_ns()));
      }
      fleet_.run(kRefineSecond_ns / 10);
    }
  }
  [[nodiscard]] std::unique_ptr<net::MergedMap> merged(std::uint32_t i) {
    auto map =
        std::make_unique<net::MergedMap>(net::MergedOptions{robots_[i].map->grid(), kRefineRoom, kRefineRoom, 8});
    map->take_all(fleet_.store(i));
    return map;
  }
  [[nodiscard]] const net::PoseRefiner& refiner(std::uint32_t i) const { return *refiners_[i]; }
  [[nodiscard]] GossipFleet& fleet() { return fleet_; }
  [[nodiscard]] int published() const { return published_; }
  /// Against where the first one says that it is.
  [[nodiscard]] double error_m(std::uint32_t i) const {
    return mapper::align::shift_of(
        mapper::align::difference(robots_[i].T_world_map, refiners_[i]->placement().T_world_map));
  }

 private:
  static tests::FleetOptions options(std::size_t robots) {
    tests::FleetOptions options;
    options.robots = static_cast<std::uint32_t>(robots);
    options.store = {8, 1U << 14, std::size_t{8} << 20, 1U << 12};
    options.radio.loss = 0.2;
    return options;
  }
  std::vector<RefinedRobot> robots_;
  GossipFleet fleet_;
  std::vector<std::unique_ptr<net::LayerWriter>> writers_;
  std::vector<std::unique_ptr<net::PoseRefiner>> refiners_;
  int published_ = 0;
};

hal::Pose off_by(const hal::Pose& pose, double x_m, double y_m, double turn_deg) {
  return hal::compose(pose, hal::from_xyz_rpy(x_m, y_m, 0, 0, 0, turn_deg * kRefineDegree));
}

}  // namespace

TEST_CASE("robots that were told wrongly where they are come to one map, and come to rest", "[net][refine][slow]") {
  const auto room = tests::furnished_room(0.05F);
  std::vector<RefinedRobot> robots(3);
  robots[1].T_world_map = hal::from_xyz_rpy(1.5, 0.4, 0, 0, 0, 0.9);
  robots[2].T_world_map = hal::from_xyz_rpy(-0.7, 1.2, 0, 0, 0, -2.0);
  robots[0].map = what_is_seen_of(*room, robots[0].T_world_map, [](const auto& p) { return p[0] < 0.9; });
  robots[1].map = what_is_seen_of(*room, robots[1].T_world_map, [](const auto& p) { return p[0] > -0.9; });
  robots[2].map = what_is_seen_of(*room, robots[2].T_world_map, [](const auto& p) { return p[1] > -0.6; });
  robots[1].T_world_said = off_by(robots[1].T_world_map, 0.2, -0.2, 5.0);
  robots[2].T_world_said = off_by(robots[2].T_world_map, -0.3, 0.05, -4.0);
  RefinedFleet team(std::move(robots));

  team.run(2);
  const tests::Agreement before = tests::agreement(team.merged(0)->map(), *room);
  team.run(28);
  REQUIRE(team.fleet().run_until_equal(10 * kRefineSecond_ns));
  INFO("errors " << team.error_m(1) << " m, " << team.error_m(2) << " m; outcomes "
                 << to_string(team.refiner(1).last().outcome) << ", " << to_string(team.refiner(2).last().outcome));
  CHECK(team.error_m(0) == 0.0);
  CHECK(team.error_m(1) < 0.05);
  CHECK(team.error_m(2) < 0.05);
  CHECK(team.refiner(1).placement().root == net::LayerId{1, 1});
  CHECK(team.refiner(2).placement().root == net::LayerId{1, 1});
  const auto merged = team.merged(0);
  const tests::Agreement there = tests::agreement(merged->map(), *room);
  const tests::Agreement back = tests::agreement(*room, merged->map());
  INFO("within a voxel: " << before.beside() << " before, " << there.beside() << " and " << back.beside() << " after");
  CHECK(before.beside() < 0.9);
  CHECK(there.beside() >= 0.98);
  CHECK(back.beside() >= 0.98);
  for (std::uint32_t i = 1; i < 3; ++i) {
    CHECK(mapper::map_hash(team.merged(i)->map()) == mapper::map_hash(merged->map()));
  }
  // At rest: nothing more is said, though there was time for it.
  const int published = team.published();
  CHECK(published <= 4);
  team.run(20);
  CHECK(team.published() == published);
}

TEST_CASE("who has nothing in common, or fits nowhere near, stays where it was said to be", "[net][refine][threads]") {
  const auto room = tests::furnished_room(0.1F);
  std::vector<RefinedRobot> robots(2);
  const double turn_deg = GENERATE(0.0, 90.0);
  robots[0].map = what_is_seen_of(*room, {}, [](const auto&) { return true; });
  robots[1].map = what_is_seen_of(*room, {}, [](const auto&) { return true; });
  robots[1].T_world_said = turn_deg == 0.0 ? hal::Pose{{20.0, 0.0, 0.0}, {0, 0, 0, 1}} : off_by({}, 0, 0, turn_deg);
  RefinedFleet team(std::move(robots));
  team.run(15);
  CHECK(team.refiner(1).counts().attempts >= 1);
  CHECK(team.published() == 0);
  CHECK(team.refiner(1).placement().depth == 0);
}
