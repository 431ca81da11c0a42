// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/retreat_trail.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::hal;
using g3d::hal::kobuki::RetreatTrail;

namespace {

PlanarPose drive(RetreatTrail& trail, PlanarPose pose, double way_m, double turn_rad_per_m = 0.0) {
  constexpr double kStep_m = 0.004;
  for (double done_m = 0.0; done_m < std::abs(way_m); done_m += kStep_m) {
    const double step_m = std::copysign(kStep_m, way_m);
    pose.heading_rad += turn_rad_per_m * kStep_m;
    pose.x_m += step_m * std::cos(pose.heading_rad);
    pose.y_m += step_m * std::sin(pose.heading_rad);
    trail.update(pose);
  }
  return pose;
}

}  // namespace

TEST_CASE("Nothing is known at the start") {
  RetreatTrail trail;
  CHECK_FALSE(trail.leads_back_from({}));
  trail.update({});
  CHECK_FALSE(trail.leads_back_from({}));
}

TEST_CASE("After a drive the way back is known, until its beginning") {
  RetreatTrail trail;
  PlanarPose pose = drive(trail, {}, 1.0);
  while (trail.leads_back_from(pose) && pose.x_m > -1.0) pose = drive(trail, pose, -0.01);
  CHECK(pose.x_m > -0.02);
  CHECK(pose.x_m < 0.08);
}

TEST_CASE("Only as far back as it remembers") {
  RetreatTrail trail;
  PlanarPose pose = drive(trail, {}, 10.0);
  double back_m = 0.0;
  while (trail.leads_back_from(pose) && back_m < 9.0) {
    pose.x_m -= 0.01;  // without an update: what it backs over is no news
    back_m += 0.01;
  }
  CHECK(back_m > 1.5);
  CHECK(back_m < 2.1);
}

TEST_CASE("Turned away from the trail, what is behind is unknown") {
  RetreatTrail trail;
  PlanarPose pose = drive(trail, {}, 1.0);
  for (const double turn_rad : {0.1, -0.1, 0.2, -0.2}) {
    pose.heading_rad = turn_rad;
    CHECK(trail.leads_back_from(pose));
  }
  for (const double turn_rad : {0.5, -0.5, 1.57, -1.57, 3.14}) {
    pose.heading_rad = turn_rad;
    CHECK_FALSE(trail.leads_back_from(pose));
  }
}

TEST_CASE("Along an arc the way back is the arc") {
  RetreatTrail trail;
  const PlanarPose pose = drive(trail, {}, 1.0, 1.0);
  CHECK(trail.leads_back_from(pose));
}

TEST_CASE("Carried away, nothing is known") {
  RetreatTrail trail;
  const PlanarPose pose = drive(trail, {}, 1.0);
  trail.forget();
  CHECK_FALSE(trail.leads_back_from(pose));
  CHECK(trail.leads_back_from(drive(trail, pose, 0.2)));
}
