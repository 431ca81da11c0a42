// SPDX-License-Identifier: Apache-2.0
#include "nav/right_of_way.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using nav::Passage;
using nav::Waypoint;

namespace {

constexpr hal::TimeNs kJudged_ns = 50'000'000'000;

nav::Teammate mate_on(std::uint64_t robot, const std::vector<nav::WayPoint>& way) {
  nav::Teammate mate;
  mate.robot = robot;
  mate.told_ns = kJudged_ns;
  mate.is_moving = way.size() > 1;
  for (const nav::WayPoint& point : way) mate.way[mate.way_count++] = point;
  mate.T_world_base = {static_cast<double>(way[0].x_m), static_cast<double>(way[0].y_m), 0.0};
  return mate;
}

struct Case {
  nav::TeamSight sight;
  nav::PathTrack track;
  hal::PlanarPose here;
  Case(std::uint64_t self, const nav::Teammate& mate, const std::vector<Waypoint>& path) {
    sight.self = self;
    sight.mates[0] = mate;
    sight.count = 1;
    track.set(path);
    here = {path[0].x_m, path[0].y_m, 0.0};
  }
  [[nodiscard]] Passage judge() const { return nav::RightOfWay({}).judge(sight, kJudged_ns, here, track, 0.0); }
};

// East along y = 0 and north along x = 2, both at the crossing after some 5 s.
const std::vector<nav::WayPoint> kNorthward{{2.0F, -2.0F, 0.0F}, {2.0F, 2.0F, 11.4F}};
const std::vector<Waypoint> kEastward{{0.0, 0.0}, {4.0, 0.0}};

}  // namespace

TEST_CASE("where ways cross at one time the higher id waits outside of the other's way", "[nav][team]") {
  const Passage second = Case(2, mate_on(1, kNorthward), kEastward).judge();
  REQUIRE(second.kind == Passage::Kind::hold);
  CHECK(second.robot == 1);
  CHECK(second.is_yielding);
  CHECK(second.within_m > 0.8);
  CHECK(second.within_m < 2.0 - 0.46);
  CHECK(Case(1, mate_on(2, kNorthward), kEastward).judge().kind == Passage::Kind::free);
}

TEST_CASE("who is through before the other comes drives on", "[nav][team]") {
  CHECK(Case(2, mate_on(1, {{2.0F, -6.0F, 0.0F}, {2.0F, 6.0F, 34.0F}}), kEastward).judge().kind == Passage::Kind::free);
}

TEST_CASE("who stands in the way of one who goes first makes room in time", "[nav][team]") {
  const std::vector<nav::WayPoint> westward{{3.0F, 0.0F, 0.0F}, {-3.0F, 0.0F, 15.0F}};
  CHECK(Case(2, mate_on(1, westward), kEastward).judge().kind == Passage::Kind::make_room);
  const std::vector<nav::WayPoint> from_afar{{6.5F, 0.0F, 0.0F}, {-3.0F, 0.0F, 40.0F}};
  CHECK(Case(2, mate_on(1, from_afar), {{0.0, 0.0}, {0.0, 0.1}}).judge().kind != Passage::Kind::make_room);
}

TEST_CASE("nobody drives into a body that stands, whatever its id", "[nav][team]") {
  for (const std::uint64_t id : {1, 9}) {
    const Passage passage = Case(5, mate_on(id, {{2.0F, 0.1F, 0.0F}}), kEastward).judge();
    REQUIRE(passage.kind == Passage::Kind::hold);
    CHECK_FALSE(passage.is_yielding);
    CHECK(passage.within_m < 2.0 - 0.36);
    CHECK(passage.within_m > 0.8);
  }
  // Beside the way it does not matter, nor behind.
  CHECK(Case(5, mate_on(1, {{2.0F, 0.6F, 0.0F}}), kEastward).judge().kind == Passage::Kind::free);
  CHECK(Case(5, mate_on(1, {{-0.37F, 0.0F, 0.0F}}), kEastward).judge().kind == Passage::Kind::free);
}

TEST_CASE("a word that is old gives nobody the right of way", "[nav][team]") {
  nav::Teammate mate = mate_on(1, kNorthward);
  mate.told_ns = kJudged_ns - 4'000'000'000;
  CHECK(Case(2, mate, kEastward).judge().kind == Passage::Kind::free);
}
