// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_path.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::hal;
using Catch::Matchers::Contains;

namespace {

/// Column of the rotation: 0 the image's right, 1 its down, 2 the optical axis, in the world.
std::array<double, 3> axis(const Pose& pose, std::size_t column) {
  const RigidTransform T = to_transform(pose);
  return {T.rotation[column], T.rotation[3 + column], T.rotation[6 + column]};
}

void check_near(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  for (std::size_t k = 0; k < 3; ++k) CHECK(a[k] == Approx(b[k]).margin(1e-6));
}

}  // namespace

TEST_CASE("yaw turns left, pitch looks up, the image stays upright") {
  const Pose ahead = camera_pose({1, 2, 3}, 0, 0);
  CHECK(is_valid(ahead));
  check_near(axis(ahead, 2), {1, 0, 0});
  check_near(axis(ahead, 0), {0, -1, 0});
  check_near(axis(ahead, 1), {0, 0, -1});
  check_near(axis(camera_pose({}, 90, 0), 2), {0, 1, 0});
  check_near(axis(camera_pose({}, 0, 30), 2), {std::sqrt(0.75), 0, 0.5});
  check_near(axis(camera_pose({}, 90, -30), 2), {0, std::sqrt(0.75), -0.5});
  // The same direction by look_at.
  const Pose a = camera_pose({0, 0, 0}, 40, -20);
  const Pose b = look_at({0, 0, 0}, axis(a, 2));
  for (std::size_t k = 0; k < 3; ++k) check_near(axis(a, k), axis(b, k));
}

TEST_CASE("a path passes its waypoints, never overshoots, and rests at its ends") {
  const auto parsed = parse_camera_path("0 0 0 1 0 0\n1 1 0 1 10 5 # half way\n3 1 4 1 20 5\n4 0 4 1 20 -5\n", "p");
  REQUIRE(parsed);
  const CameraPath& path = parsed.value();
  CHECK(path.begin_ns() == 0);
  CHECK(path.end_ns() == 4'000'000'000);
  check_near(path.pose_at(1'000'000'000).translation_m, {1, 0, 1});
  check_near(path.pose_at(3'000'000'000).translation_m, {1, 4, 1});
  check_near(path.pose_at(-5).translation_m, {0, 0, 1});
  check_near(path.pose_at(9'000'000'000).translation_m, {0, 4, 1});
  double last_y = 0.0;
  for (TimeNs t = 0; t <= 4'000'000'000; t += 10'000'000) {
    const auto p = path.pose_at(t).translation_m;
    REQUIRE(p[0] >= -1e-12);
    REQUIRE(p[0] <= 1 + 1e-12);
    REQUIRE(p[1] >= last_y - 1e-12);
    REQUIRE(p[1] - last_y < 0.05);  // smooth: at most 4 m in 2 s, and some
    last_y = p[1];
  }
}

TEST_CASE("yaw takes the shorter way round") {
  const auto parsed = parse_camera_path("0 0 0 0 170 0\n1 0 0 0 -170 0\n2 0 0 0 -150 0\n", "p");
  REQUIRE(parsed);
  const auto half_way = axis(parsed.value().pose_at(500'000'000), 2);
  CHECK(half_way[0] < -0.98);
  check_near(axis(parsed.value().pose_at(1'000'000'000), 2), axis(camera_pose({}, 190, 0), 2));
}

TEST_CASE("laps go round and round, yaw included") {
  const auto parsed = parse_camera_path("1 0 0 0 0 0\n2 1 0 0 120 0\n3 1 1 0 240 0\n4 0 0 0 0 0\n", "p");
  REQUIRE(parsed);
  const CameraPath& once = parsed.value();
  const CameraPath thrice = once.laps(3);
  CHECK(thrice.begin_ns() == once.begin_ns());
  CHECK(thrice.end_ns() == 10'000'000'000);
  for (const std::int64_t at_s : {1, 2, 3, 4}) {
    for (const std::int64_t lap : {0, 1, 2}) {
      CAPTURE(at_s, lap);
      const Pose expected = once.pose_at(at_s * 1'000'000'000);
      const Pose pose = thrice.pose_at((at_s + 3 * lap) * 1'000'000'000);
      check_near(pose.translation_m, expected.translation_m);
      check_near(axis(pose, 2), axis(expected, 2));
    }
  }
  const CameraPath same = once.laps(1);
  CHECK(same.pose_at(1'700'000'000).translation_m == once.pose_at(1'700'000'000).translation_m);
  const auto at_rest = parse_camera_path("2.5 1 2 3 90 0", "p");
  REQUIRE(at_rest);
  CHECK(at_rest.value().laps(5).end_ns() == at_rest.value().end_ns());
}

TEST_CASE("a single waypoint is a camera at rest") {
  const auto parsed = parse_camera_path("2.5 1 2 3 90 0", "p");
  REQUIRE(parsed);
  CHECK(parsed.value().begin_ns() == parsed.value().end_ns());
  check_near(parsed.value().pose_at(0).translation_m, {1, 2, 3});
}

TEST_CASE("errors of a camera path name file and line") {
  struct Row {
    const char* text;
    Reason reason;
    const char* says;
  };
  const Row rows[] = {
      {"", Reason::malformed, "p.path: no waypoint"},
      {"0 0 0 0 0\n", Reason::malformed, "p.path:1: a waypoint is six numbers"},
      {"0 0 0 0 0 0 0\n", Reason::malformed, "six numbers"},
      {"0 0 0 0 0 0\n\n0 1 1 1 1 1\n", Reason::malformed, "p.path:3: t_s must be"},
      {"-1 0 0 0 0 0\n", Reason::out_of_range, "t_s is -1"},
      {"0 0 0 0 0 91\n", Reason::out_of_range, "pitch_deg is 91"},
      {"0 0 inf 0 0 0\n", Reason::malformed, "y is 'inf'"},
      {"0 2000 0 0 0 0\n", Reason::out_of_range, "x is 2000"},
  };
  for (const Row& row : rows) {
    CAPTURE(row.text);
    const auto parsed = parse_camera_path(row.text, "p.path");
    REQUIRE_FALSE(parsed.ok());
    CHECK(parsed.error().reason == row.reason);
    CHECK_THAT(parsed.error().text, Contains(row.says));
  }
}
