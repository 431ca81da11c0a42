// SPDX-License-Identifier: Apache-2.0
#include "nav/passer_tracks.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <string>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"
#include "hal/sim/world_file.hpp"
#include "nav/passers.hpp"

using namespace g3d;
using nav::CellState;

namespace {

constexpr hal::TimeNs kFrame_ns = 100'000'000;
const hal::CameraModel kCamera = hal::scaled_kinect(160, 120);

hal::TimeNs at_s(double t_s) { return static_cast<hal::TimeNs>(t_s * 1e9); }

// So that what is left of somebody is where he goes.
nav::Passers soon_forgets(const nav::CellGrid<CellState>& like) {
  nav::PassersConfig config;
  config.hold_s = 0.5;
  return {like, config};
}

// Somebody walks straight through the view of a robot that stands at the origin, looking along x.
struct Walk {
  double from_x_m = 2.0, from_y_m = -0.6;
  double vx_mps = -0.2, vy_mps = 0.6;
  nav::CellGrid<CellState> floor;
  nav::MovedLately moved;
  nav::DepthScan scan;
  nav::Passers passers;
  hal::Frame frame = hal::make_frame(kCamera);

  // g++ 12 sees dangling pointers in member initialisers where there are none.
  Walk()
      : floor(0.05, -4.0, -4.0, 160, 160, CellState::free),
        moved(floor),
        scan(nav::DepthScanConfig()),
        passers(soon_forgets(floor)) {}

  [[nodiscard]] double x_m(double t_s) const { return from_x_m + t_s * vx_mps; }
  [[nodiscard]] double y_m(double t_s) const { return from_y_m + t_s * vy_mps; }

  void look(double t_s, bool is_he_there = true, const hal::PlanarPose& pose = {}) {
    std::string text = "floor 0 0 0 20 20 0.1\n";
    if (is_he_there) text += "cylinder " + std::to_string(x_m(t_s)) + " " + std::to_string(y_m(t_s)) + " 0  0.2 1.8\n";
    hal::SimBuildingOptions options;
    options.camera = kCamera;
    options.noise = true;
    options.robots.emplace_back().T_world_base = pose;
    hal::SimBuilding building(hal::parse_world(text, "w").value(), options);
    building.render(0, frame);
    scan.look(frame, kCamera);
    passers.look(scan, floor, moved, pose, at_s(t_s));
  }
  void look_until(double end_s) {
    for (hal::TimeNs t = kFrame_ns; t <= at_s(end_s); t += kFrame_ns) look(1e-9 * static_cast<double>(t));
  }
  /// Nobody has looked there lately, and he could have gone there.
  [[nodiscard]] bool may_have_come(double x, double y, double t_s) const {
    return passers.may_have_come(floor.cell_of(x, y), at_s(t_s));
  }
  [[nodiscard]] bool may_come(double x, double y, double t_s) const {
    return passers.is_there(floor.cell_of(x, y), at_s(t_s));
  }
};

}  // namespace

TEST_CASE("Who left the view at its side is where his way has led him since", "[nav][passers]") {
  Walk walk;  // beside the view's edge, 28 degrees to the left, from 2.4 s on
  walk.look_until(4.0);
  for (const double t_s : {4.0, 4.5, 5.5, 6.5}) {
    CAPTURE(t_s);
    CHECK(walk.may_come(walk.x_m(t_s), walk.y_m(t_s), t_s));
    CHECK(walk.may_come(walk.x_m(t_s + 1.0), walk.y_m(t_s + 1.0), t_s));
    CHECK_FALSE(walk.may_come(walk.x_m(t_s - 1.5), walk.y_m(t_s - 1.5), t_s));
    CHECK_FALSE(walk.may_come(walk.x_m(t_s + 4.0), walk.y_m(t_s + 4.0), t_s));
  }
}

TEST_CASE("A guess ends: nobody stays away for ever because somebody once walked by", "[nav][passers]") {
  Walk walk;
  walk.look_until(4.0);
  REQUIRE(walk.may_come(walk.x_m(5.0), walk.y_m(5.0), 5.0));
  CHECK_FALSE(walk.may_come(walk.x_m(10.5), walk.y_m(10.5), 10.5));
}

TEST_CASE("Who stands still and who was seen for a moment only is not guessed at", "[nav][passers]") {
  Walk stands;
  stands.vx_mps = stands.vy_mps = 0.0;
  stands.look_until(2.0);
  stands.look(2.1, false, {0.0, 0.0, 2.0});
  for (const double y_m : {-1.4, 0.2, 0.6}) CHECK_FALSE(stands.may_come(stands.x_m(0.0), y_m, 3.0));

  Walk short_sight;
  short_sight.look_until(0.3);
  short_sight.look(0.4, false, {0.0, 0.0, 2.0});
  CHECK_FALSE(short_sight.may_come(short_sight.x_m(2.0), short_sight.y_m(2.0), 2.0));
}

TEST_CASE("Who stopped before the robot is a body, also when it turns to go around him", "[nav][passers]") {
  Walk walk;
  walk.from_x_m = 2.5;
  walk.from_y_m = 0.0;
  walk.vx_mps = -0.8;
  walk.vy_mps = 0.0;
  walk.look_until(1.5);  // at 1.3 m now
  const double stands_x_m = walk.x_m(1.5);
  walk.from_x_m = stands_x_m;
  walk.vx_mps = 0.0;
  for (double t_s = 1.6; t_s < 4.0; t_s += 0.1) walk.look(t_s);
  CHECK(walk.may_come(stands_x_m + 0.1, 0.15, 3.9));  // behind his front, which is all that is measured
  CHECK(walk.may_come(stands_x_m - 0.1, -0.15, 3.9));
  CHECK_FALSE(walk.may_come(stands_x_m - 0.5, 0.0, 3.9));
  CHECK_FALSE(walk.may_come(stands_x_m, 0.45, 3.9));
  walk.look(4.0, true, {0.0, 0.0, 1.0});
  CHECK(walk.may_come(stands_x_m + 0.1, 0.15, 8.0));
  CHECK_FALSE(walk.may_come(stands_x_m - 0.5, 0.0, 8.0));
  CHECK_FALSE(walk.may_come(stands_x_m + 0.1, 0.15, 10.5));
}

TEST_CASE("Who has become a part of the map is still somebody, but walls that look new are nobody",
          "[nav][passers][slow]") {
  nav::DepthScan scan{nav::DepthScanConfig()};
  const nav::CellGrid<CellState> floor{0.05, -4.0, -4.0, 160, 160, CellState::free};
  const nav::MovedLately moved{floor};
  hal::Frame frame = hal::make_frame(kCamera);
  for (const bool walked : {false, true}) {
    nav::PasserTracks tracks{{}};
    double x_m = 2.0;
    for (int i = 0; i <= 80; ++i) {
      const bool walks = walked && i < 15;
      if (walks) x_m -= 0.05;
      hal::SimBuildingOptions options;
      options.camera = kCamera;
      options.noise = false;
      options.robots.emplace_back();
      const std::string text = "floor 0 0 0 20 20 0.1\ncylinder " + std::to_string(x_m) + " 0 0 0.2 1.8\n";
      hal::SimBuilding building(hal::parse_world(text, "w").value(), options);
      building.render(0, frame);
      scan.look(frame, kCamera);
      nav::PasserTracks::Rays hits{};
      for (std::size_t k = 0; k < hits.size(); ++k) hits[k] = scan.rays()[k].has_hit;
      if (i < 20) {
        tracks.look(scan, hits, {}, floor, moved, {}, at_s(0.1 * i));
      } else {
        tracks.look(scan, {}, hits, floor, moved, {}, at_s(0.1 * i));
      }
    }
    CHECK(tracks.may_come(x_m, 0.1, at_s(8.1)) == walked);
  }
}

TEST_CASE("Where the camera looks and sees through, he is not", "[nav][passers]") {
  Walk walk;
  walk.look_until(1.0);
  walk.look(1.1, false, {0.0, 0.0, 2.0});  // looks away
  REQUIRE(walk.may_come(walk.x_m(1.5), walk.y_m(1.5), 1.5));
  walk.look(1.6, false);
  CHECK_FALSE(walk.may_come(walk.x_m(1.8), walk.y_m(1.8), 1.8));
}

TEST_CASE("Nobody walks through walls", "[nav][passers]") {
  Walk walk;
  for (int i = 0; i < 40; ++i) walk.floor.at(walk.floor.cell_of(0.5 + 0.05 * i, 1.5)) = CellState::occupied;
  walk.look_until(5.0);  // behind the wall since 3.5 s, and out of view
  CHECK_FALSE(walk.may_come(walk.x_m(5.2), walk.y_m(5.2), 5.2));
}

TEST_CASE("Two who cross are two", "[nav][passers]") {
  nav::PasserTracks tracks{{}};
  nav::DepthScan scan{{}};
  nav::CellGrid<CellState> floor{0.05, -4.0, -4.0, 160, 160, CellState::free};
  nav::MovedLately moved{floor};
  hal::Frame frame = hal::make_frame(kCamera);
  for (int i = 0; i <= 20; ++i) {
    const double t_s = 0.1 * i;
    hal::SimBuildingOptions options;
    options.camera = kCamera;
    options.noise = false;
    options.robots.emplace_back();
    const std::string text = "floor 0 0 0 20 20 0.1\ncylinder 1.5 " + std::to_string(-0.5 + 0.5 * t_s) +
                             " 0 0.15 1.8\ncylinder 2.4 " + std::to_string(0.7 - 0.5 * t_s) + " 0 0.15 1.8\n";
    hal::SimBuilding building(hal::parse_world(text, "w").value(), options);
    building.render(0, frame);
    scan.look(frame, kCamera);
    std::array<bool, nav::DepthScan::kRays> is_somebody{};
    for (std::size_t k = 0; k < is_somebody.size(); ++k) is_somebody[k] = scan.rays()[k].has_hit;
    tracks.look(scan, is_somebody, {}, floor, moved, {}, at_s(t_s));
  }
  frame = hal::make_frame(kCamera);  // blinded
  scan.look(frame, kCamera);
  tracks.look(scan, {}, {}, floor, moved, {}, at_s(2.1));
  CHECK(tracks.may_come(1.4, 1.0, at_s(2.5)));
  CHECK(tracks.may_come(2.3, -0.8, at_s(2.5)));
  CHECK_FALSE(tracks.may_come(1.9, 0.1, at_s(2.5)));
}

TEST_CASE("Who has walked may be anywhere that he could have reached, but where the camera has just looked",
          "[nav][passers]") {
  Walk walk;
  walk.look_until(2.0);
  CHECK_FALSE(walk.may_have_come(1.0, 0.1, 2.0));  // looked through
  const hal::PlanarPose turned{0.0, 0.0, 2.4};
  for (double t_s = 2.1; t_s < 6.05; t_s += 0.1) walk.look(t_s, false, turned);
  CHECK_FALSE(walk.may_have_come(1.0, 0.1, 3.0));   // not long ago
  CHECK(walk.may_have_come(1.0, 0.1, 6.0));         // he may have turned round
  CHECK(walk.may_have_come(-0.2, -1.0, 6.0));       // never looked at
  CHECK_FALSE(walk.may_have_come(-0.8, 0.7, 6.0));  // in view
  CHECK_FALSE(walk.may_have_come(9.0, 0.0, 6.0));   // not of this floor
  CHECK_FALSE(walk.may_have_come(1.0, 0.1, 20.0));  // long gone
}

TEST_CASE("What has hardly moved is nobody who may be anywhere") {
  Walk slides;  // 0.19 m, as noise does along a wall
  slides.vx_mps *= 0.5;
  slides.vy_mps *= 0.5;
  slides.look_until(0.6);
  slides.look(0.7, false, {0.0, 0.0, 2.4});
  const bool is_known = slides.may_have_come(1.0, -1.0, 5.0);
  Walk walks;
  walks.look_until(2.0);
  walks.look(2.1, false, {0.0, 0.0, 2.4});
  CHECK_FALSE(is_known);
  CHECK(slides.may_come(slides.x_m(0.8), slides.y_m(0.8), 0.8));  // but he is followed
  CHECK(walks.may_have_come(1.0, -1.0, 5.0));
}

TEST_CASE("Nobody is expected where nobody has walked, nor farther off than anybody walks", "[nav][passers]") {
  Walk nobody;
  for (double t_s = 0.1; t_s < 1.0; t_s += 0.1) nobody.look(t_s, false);
  CHECK_FALSE(nobody.may_have_come(1.0, 0.1, 9.0));
  Walk stands;
  stands.vx_mps = stands.vy_mps = 0.0;
  stands.from_y_m = 0.0;
  stands.look_until(1.0);
  stands.look(1.1, false, {0.0, 0.0, 2.4});
  CHECK_FALSE(stands.may_have_come(1.0, 0.1, 9.0));
  Walk walk;
  walk.look_until(2.0);
  walk.look(2.1, false, {0.0, 0.0, 2.4});
  CHECK(walk.may_have_come(1.0, -1.0, 5.0));
  CHECK_FALSE(walk.may_have_come(-3.5, 0.0, 5.0));  // 5 m in 3 s
}
