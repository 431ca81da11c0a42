// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/align_report.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <string>

using namespace g3d::mapper::align;

TEST_CASE("only corrected frames count towards the corrections", "[mapper][align]") {
  AlignReport report;
  report.count(AlignOutcome::first, {}, false, false);
  report.count(AlignOutcome::aligned, {0.03, 0.04, 0.0, 0.0, 0.0, 0.01}, true, false);
  report.count(AlignOutcome::aligned, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, false, true);
  report.count(AlignOutcome::no_better, {9.0, 9.0, 9.0, 1.0, 1.0, 1.0}, true, true);
  CHECK(report.corrected() == 2);
  CHECK(report.held_shift_frames == 1);
  CHECK(report.held_turn_frames == 1);
  CHECK(report.largest_shift_m == Approx(0.05));
  CHECK(report.shift_rms_m() == Approx(0.05 / std::sqrt(2.0)));
  CHECK(report.turn_rms_rad() == Approx(0.01 / std::sqrt(2.0)));
  CHECK(report.frames[static_cast<std::size_t>(AlignOutcome::no_better)] == 1);
}

TEST_CASE("a report without frames divides by nothing", "[mapper][align]") {
  CHECK(AlignReport{}.shift_rms_m() == 0.0);
  CHECK(AlignReport{}.turn_rms_rad() == 0.0);
}

TEST_CASE("every outcome and every mode has a name of its own", "[mapper][align]") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kAlignOutcomeCount; ++i) names.insert(to_string(static_cast<AlignOutcome>(i)));
  CHECK(names.size() == kAlignOutcomeCount);
  for (const auto mode : {OdometryMode::given, OdometryMode::aligned, OdometryMode::none}) {
    CHECK(odometry_mode_from_string(to_string(mode)) == mode);
  }
  CHECK_FALSE(odometry_mode_from_string("guessed"));
}
