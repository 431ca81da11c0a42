// SPDX-License-Identifier: Apache-2.0
#include "mapper/trajectory_writer.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <string>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using mapper::format_trajectory_line;
using mapper::TrajectoryWriter;

TEST_CASE("a line keeps every nanosecond of the stamp", "[mapper][trajectory]") {
  mapper::TrajectoryLine buffer;
  const hal::Pose pose{{1.5, -2.25, 0.0}, {0.0, 0.0, 0.6, 0.8}};
  CHECK(format_trajectory_line(1305031229123456789, pose, buffer) ==
        "1305031229.123456789 1.500000 -2.250000 0.000000 0.000000000 0.000000000 0.600000000 0.800000000\n");
  CHECK(format_trajectory_line(-1, pose, buffer).starts_with("-0.000000001 "));
  CHECK(format_trajectory_line(INT64_MIN, pose, buffer).starts_with("-9223372036.854775808 "));
}

TEST_CASE("an absurd pose does not run over the buffer", "[mapper][trajectory]") {
  mapper::TrajectoryLine buffer;
  const hal::Pose pose{{1e300, 1e300, -1e300}, {0, 0, 0, 1}};
  CHECK(format_trajectory_line(0, pose, buffer).size() == buffer.size());
}

TEST_CASE("the file appears when it is finished, not before", "[mapper][trajectory]") {
  const test::TempFolder folder;
  const std::string path = folder / "trajectory.tum";
  {
    auto writer = TrajectoryWriter::create(path);
    REQUIRE(writer.ok());
    writer.value().add(1'000'000'000, {});
    CHECK(folder.listing().find("trajectory.tum\n") == std::string::npos);
    REQUIRE(writer.value().finish().ok());
  }
  const std::string text = test::read_plain(path);
  CHECK(text.starts_with("# "));
  CHECK(text.find("\n1.000000000 0.000000 0.000000 0.000000 0.000000000 0.000000000 0.000000000 1.000000000\n") !=
        std::string::npos);
}

TEST_CASE("a folder that does not exist is an error that names it", "[mapper][trajectory]") {
  const auto writer = TrajectoryWriter::create("/nonexistent/folder/trajectory.tum");
  REQUIRE_FALSE(writer.ok());
  CHECK(writer.error().text.find("/nonexistent/folder/trajectory.tum") != std::string::npos);
}
