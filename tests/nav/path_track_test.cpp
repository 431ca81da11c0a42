// SPDX-License-Identifier: Apache-2.0
#include "nav/path_track.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;
using nav::PathTrack;
using nav::Waypoint;

TEST_CASE("Progress is the nearest point of the path and the rest is what remains") {
  PathTrack track;
  CHECK(track.empty());
  const std::vector<Waypoint> path{{0, 0}, {2, 0}, {2, 1}};
  track.set(path);
  CHECK(track.length_m() == Approx(3.0));
  track.advance(0.5, 0.2);
  CHECK(track.travelled_m() == Approx(0.5));
  CHECK(track.offset_m() == Approx(0.2));
  CHECK(track.remaining_m() == Approx(2.5));
  CHECK(track.ahead(1.0).x_m == Approx(1.5));
  CHECK(track.ahead(2.0).x_m == Approx(2.0));
  CHECK(track.ahead(2.0).y_m == Approx(0.5));
  CHECK(track.ahead(99.0) == Waypoint{2, 1});
  track.advance(1.4, 0.0);
  track.advance(1.9, 0.1);
  track.advance(2.1, 0.6);
  CHECK(track.travelled_m() == Approx(2.6));
}

TEST_CASE("Progress does not go back, and does not jump to a later lap that comes near") {
  PathTrack track;
  const std::vector<Waypoint> hairpin{{0, 0}, {4, 0}, {4, 0.3}, {0, 0.3}};
  track.set(hairpin);
  track.advance(1.0, 0.2);  // nearer to the way back, 6.3 m along
  CHECK(track.travelled_m() == Approx(1.0));
  track.advance(0.2, 0.0);
  CHECK(track.travelled_m() == Approx(1.0));
}

TEST_CASE("Points that repeat, paths of one point and paths that are too long are taken as they are") {
  PathTrack track(3);
  const std::vector<Waypoint> repeating{{0, 0}, {0, 0}, {1, 0}, {1, 0}, {2, 0}};
  track.set(repeating);
  CHECK(track.length_m() == Approx(1.0));  // cut after three points
  const std::vector<Waypoint> single{{1, 1}};
  track.set(single);
  track.advance(0, 0);
  CHECK(track.remaining_m() == 0.0);
  CHECK(track.ahead(0.5) == Waypoint{1, 1});
  track.clear();
  CHECK(track.empty());
  track.advance(0, 0);
}
