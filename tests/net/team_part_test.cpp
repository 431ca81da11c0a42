// SPDX-License-Identifier: Apache-2.0
#include "net/team_part.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "hal/geometry.hpp"
#include "mapper/voxel_map.hpp"
#include "net/sim_radio.hpp"

using namespace g3d;

namespace {

/// Two robots with maps of nothing, joined by a radio.
struct TwoParts {
  struct Robot final : net::Link {
    Robot(TwoParts& of, std::uint32_t its_number, const hal::Pose& T_world_map)
        : both(of), number(its_number), sharing(options(its_number), of.nothing, *this), part(link, status, 0.2F) {
      (void)sharing.publish_pose(T_world_map, 0);
    }
    static net::SharingOptions options(std::uint32_t number) {
      net::SharingOptions options;
      options.gossip.self = {number + 1, 1};
      options.store = {4, 1U << 10, std::size_t{1} << 18};
      options.most_submaps = 2;
      return options;
    }
    bool send(net::Address, mapper::ByteSpan message) override {
      both.radio.send(number, net::SimRadio::kEveryStation, message, both.now_ns);
      return true;
    }
    TwoParts& both;
    std::uint32_t number;
    nav::TeamLink link;
    hal::Latest<nav::LiveStatus> status;
    net::MapSharing sharing;
    net::TeamPart part;
  };
  explicit TwoParts(const hal::Pose& T_world_second)
      : robots{std::make_unique<Robot>(*this, 0, hal::Pose{}), std::make_unique<Robot>(*this, 1, T_world_second)} {}
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      now_ns += 10'000'000;
      radio.deliver(now_ns, [&](std::uint32_t from, std::uint32_t to, mapper::ByteSpan message) {
        robots[to]->sharing.on_message({from + 1, 1, from + 1}, message, now_ns);
      });
      for (auto& robot : robots) {
        (void)robot->sharing.on_time(now_ns);
        robot->part.on_round(robot->sharing, now_ns);
      }
    }
  }
  hal::TimeNs now_ns = 1'000'000'000;
  mapper::VoxelMap nothing{mapper::Grid{0.1F}, mapper::MapCapacity{64, 64, 16}};
  net::SimRadio radio{2, {0.0, 0.0, 0.0, 2'000'000, 1'000'000, 0, 3}};
  std::array<std::unique_ptr<Robot>, 2> robots;
};

}  // namespace

TEST_CASE("a robot with threads sees its teammate where its own map has that place", "[net][team]") {
  // The second map begins at (1, 2), a quarter turned to the left.
  TwoParts both(hal::from_xyz_rpy(1.0, 2.0, 0.0, 0.0, 0.0, 1.5707963267948966));
  nav::TeamWord word;
  word.T_world_base = {1.0, 4.0, 0.0};
  word.has_goal = true;
  word.goal = {1.0, 5.0, 0.0};
  both.robots[0]->link.word.write(word);
  nav::LiveStatus status;
  status.state = nav::MissionState::exploring;
  status.battery_charge = 0.42;
  both.robots[0]->status.write(status);
  word = {};
  both.robots[1]->link.word.write(word);
  both.run(300);

  nav::TeamSight sight;
  REQUIRE(both.robots[1]->link.sight.read(sight) > 0);
  CHECK(sight.self == 2);
  REQUIRE(sight.count == 1);
  CHECK(sight.mates[0].robot == 1);
  CHECK(sight.mates[0].radius_m == Approx(0.2F).margin(0.01));
  CHECK(sight.mates[0].T_world_base.x_m == Approx(2.0).margin(0.02));
  CHECK(sight.mates[0].T_world_base.y_m == Approx(0.0).margin(0.02));
  CHECK(sight.mates[0].has_goal);
  CHECK(sight.mates[0].goal.x_m == Approx(3.0).margin(0.02));
  REQUIRE(both.robots[0]->link.sight.read(sight) > 0);
  REQUIRE(sight.count == 1);
  CHECK(sight.mates[0].T_world_base.x_m == Approx(1.0).margin(0.02));
  CHECK(sight.mates[0].T_world_base.y_m == Approx(2.0).margin(0.02));

  const net::TeamTalk* talk = both.robots[1]->part.talk();
  REQUIRE(talk != nullptr);
  const net::RobotWords* words = talk->book().find(1);
  REQUIRE(words != nullptr);
  CHECK(words->state.mission == nav::MissionState::exploring);
  CHECK(words->state.battery_percent == 42);
  // One leads both.
  CHECK(both.robots[0]->part.talk()->cluster().is_leader() != talk->cluster().is_leader());
}

TEST_CASE("who has not said anything yet is in nobody's sight", "[net][team]") {
  TwoParts both({});
  both.robots[0]->link.word.write({});
  both.run(200);
  nav::TeamSight sight;
  REQUIRE(both.robots[0]->link.sight.read(sight) > 0);
  CHECK(sight.count == 0);
  CHECK(both.robots[1]->part.talk() == nullptr);
  CHECK(both.robots[1]->link.sight.generation() == 0);
}
