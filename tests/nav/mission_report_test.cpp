// SPDX-License-Identifier: Apache-2.0
#include "nav/mission_report.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string_view>

using namespace g3d;
using nav::MissionReport;

TEST_CASE("Way and turning are summed over the poses") {
  MissionReport report;
  CHECK(report.time_s(123) == 0.0);
  report.note_pose({1.0, 1.0, 3.0}, 1'000'000'000);
  CHECK(report.path_m == 0.0);
  report.note_pose({4.0, 5.0, 3.0}, 2'000'000'000);
  report.note_pose({4.0, 5.0, -3.0}, 3'000'000'000);  // the short way round
  CHECK(report.path_m == Approx(5.0));
  CHECK(report.rotation_rad == Approx(2 * 3.14159265358979 - 6.0));
  CHECK(report.time_s(3'500'000'000) == Approx(2.5));
}

TEST_CASE("Times to a coverage are read from the samples") {
  MissionReport report;
  report.note_pose({}, 0);
  for (int i = 0; i <= 10; ++i) report.note_coverage(0.1 * i, i * 1'000'000'000LL);
  REQUIRE(report.time_to_s(0.45));
  CHECK(*report.time_to_s(0.45) == Approx(5.0));
  CHECK_FALSE(report.time_to_s(1.01));
  CHECK(report.coverage().size() == 11);
}

TEST_CASE("Samples beyond what was reserved replace the last one") {
  MissionReport report(3);
  report.note_pose({}, 0);
  for (int i = 0; i < 100; ++i) report.note_coverage(0.01 * i, i);
  CHECK(report.coverage().size() == 3);
  CHECK(report.coverage().back().fraction == Approx(0.99));
}

TEST_CASE("Stops are counted by reason, and every reason has a name of its own") {
  MissionReport report;
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < nav::kStopReasons; ++i) {
    report.note_stop(static_cast<nav::StopReason>(i));
    names.insert(nav::name_of(static_cast<nav::StopReason>(i)));
    CHECK(report.stops[i] == 1);
  }
  CHECK(names.size() == nav::kStopReasons);
  CHECK(names.count("unknown") == 0);
}
