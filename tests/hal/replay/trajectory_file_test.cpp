// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/trajectory_file.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/support/temp_folder.hpp"

using namespace g3d::hal;

TEST_CASE("A trajectory is read back to the last bit") {
  const g3d::test::TempFolder folder;
  const std::string path = folder / "trajectory.tum";
  std::mt19937 rng(6);
  std::normal_distribution<double> normal;
  std::vector<StampedPose> poses;
  for (int i = 0; i < 300; ++i) {
    StampedPose pose;
    pose.stamp_ns = 1305031230965035001 + i * TimeNs{33'333'333};
    for (double& t : pose.T_world_camera.translation_m) t = 1e-3 * normal(rng);
    for (double& q : pose.T_world_camera.rotation_xyzw) q = normal(rng);
    poses.push_back(pose);
  }
  REQUIRE(write_trajectory(path, poses).ok());
  const std::vector<StampedPose> back = read_trajectory(path).value();
  REQUIRE(back.size() == poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CHECK(back[i].stamp_ns == poses[i].stamp_ns);
    CHECK(back[i].T_world_camera.translation_m == poses[i].T_world_camera.translation_m);
    CHECK(back[i].T_world_camera.rotation_xyzw == poses[i].T_world_camera.rotation_xyzw);
  }
  CHECK(format_pose_line({500'000'000, {{1, -2.5, 0}, {0, 0, 0, 1}}}) == "0.500000000 1 -2.5 0 0 0 0 1\n");
}

TEST_CASE("A writer without commit leaves what was there") {
  const g3d::test::TempFolder folder;
  const std::string path = folder / "trajectory.tum";
  REQUIRE(write_trajectory(path, {}).ok());
  {
    Result<TrajectoryWriter> writer = TrajectoryWriter::create(path);
    REQUIRE(writer.ok());
    REQUIRE(writer.value().append({}).ok());
  }
  CHECK(read_trajectory(path).value().empty());
  CHECK(folder.listing() == "trajectory.tum\n");
  CHECK_FALSE(write_trajectory("/nowhere/at/all.tum", {}).ok());
}

TEST_CASE("NaN poses are read as they are, text that is no pose names its line") {
  const auto poses = parse_trajectory("# c\n1 nan 0 0 0 0 0 1\n2 1 2 3 0 0 0 1\n2 1 2 3 0 0 0 1\n", "p").value();
  REQUIRE(poses.size() == 3);
  CHECK(std::isnan(poses[0].T_world_camera.translation_m[0]));
  CHECK(poses[1].T_world_camera.translation_m[2] == 3);

  const auto error = [](const char* text) { return parse_trajectory(text, "p.txt").error().text; };
  CHECK(error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n").find("p.txt:2: ") == 0);
  CHECK(error("\n\n1 0 0 0 0 0 0 1 9\n").find("p.txt:3: ") == 0);
  CHECK(error("x 0 0 0 0 0 0 1").find("p.txt:1: ") == 0);
  CHECK(error("1 0 0 0 0 0 0 one").find("p.txt:1: ") == 0);
  CHECK(error("2 0 0 0 0 0 0 1\n1.5 0 0 0 0 0 0 1").find("p.txt:2: stamp 1.500000000 is earlier") == 0);
  CHECK(parse_trajectory("", "p").value().empty());
}
