// SPDX-License-Identifier: Apache-2.0
#include "mapper/run_sink.hpp"

#include <catch2/catch.hpp>
#include <string>

#include "tests/support/temp_folder.hpp"

using namespace g3d;

TEST_CASE("a run's poses are in the trajectory once it is finished", "[mapper][run_sink]") {
  const test::TempFolder folder;
  const std::string path = folder / "trajectory.tum";
  auto trajectory = hal::TrajectoryWriter::create(path);
  REQUIRE(trajectory.ok());
  mapper::ProgressBar bar(stderr, mapper::ProgressStyle::quiet, 3);
  const hal::RealClock clock;
  mapper::RunSink sink(trajectory.value(), bar, clock);
  for (int i = 1; i <= 3; ++i) {
    sink.on_frame({i * 1'000'000'000LL, {{0.5 * i, -1.0, 2.0}, {0, 0, 0, 1}}, {}, {}});
    sink.on_progress({static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(i), 0});
  }
  CHECK(folder.listing().find("trajectory.tum\n") == std::string::npos);
  REQUIRE(sink.finish().ok());
  const auto poses = hal::read_trajectory(path);
  REQUIRE(poses.ok());
  REQUIRE(poses.value().size() == 3);
  CHECK(poses.value()[2].stamp_ns == 3'000'000'000);
  CHECK(poses.value()[2].T_world_camera.translation_m == std::array{1.5, -1.0, 2.0});
}

TEST_CASE("where poses are corrected, odometry's are kept beside them", "[mapper][run_sink]") {
  const test::TempFolder folder;
  auto trajectory = hal::TrajectoryWriter::create(folder / "trajectory.tum");
  auto odometry = hal::TrajectoryWriter::create(folder / "odometry.tum");
  REQUIRE(trajectory.ok());
  REQUIRE(odometry.ok());
  mapper::ProgressBar bar(stderr, mapper::ProgressStyle::quiet, 1);
  const hal::RealClock clock;
  mapper::RunSink sink(trajectory.value(), bar, clock, &odometry.value());
  sink.on_frame({1'000'000'000, {{0.5, -1.0, 2.0}, {0, 0, 0, 1}}, {{0.7, -1.0, 2.0}, {0, 0, 0, 1}}, {}});
  REQUIRE(sink.finish().ok());
  CHECK(hal::read_trajectory(folder / "trajectory.tum").value()[0].T_world_camera.translation_m[0] == 0.5);
  CHECK(hal::read_trajectory(folder / "odometry.tum").value()[0].T_world_camera.translation_m[0] == 0.7);
}

TEST_CASE("a trajectory that cannot be kept is an error at the end, not before", "[mapper][run_sink]") {
  const test::TempFolder folder;
  auto trajectory = hal::TrajectoryWriter::create(folder / "sub/trajectory.tum");
  REQUIRE(trajectory.ok());
  mapper::ProgressBar bar(stderr, mapper::ProgressStyle::quiet, std::nullopt);
  const hal::RealClock clock;
  mapper::RunSink sink(trajectory.value(), bar, clock);
  std::filesystem::remove_all(folder / "sub");
  sink.on_frame({});
  const auto finished = sink.finish();
  REQUIRE_FALSE(finished.ok());
  CHECK(finished.error().text.find("trajectory.tum") != std::string::npos);
}
