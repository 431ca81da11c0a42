// SPDX-License-Identifier: Apache-2.0
#include "mapper/stage_times.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

using g3d::mapper::StageTimes;

TEST_CASE("no durations give zeros", "[mapper][stage_times]") {
  const StageTimes times;
  CHECK(times.count() == 0);
  CHECK(times.percentile_us(0.5) == 0.0);
  CHECK(times.max_us() == 0.0);
  CHECK(times.mean_us() == 0.0);
}

TEST_CASE("one duration is its own percentile, exactly", "[mapper][stage_times]") {
  StageTimes times;
  times.add(123456);
  CHECK(times.percentile_us(0.01) == Approx(123.456));
  CHECK(times.percentile_us(0.99) == Approx(123.456));
  CHECK(times.max_us() == Approx(123.456));
}

TEST_CASE("percentiles are within a bucket of the sorted truth", "[mapper][stage_times]") {
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> duration_ns(14.0, 1.5);
  StageTimes times;
  std::vector<double> all_us;
  for (int i = 0; i < 20001; ++i) {
    const auto ns = static_cast<std::int64_t>(duration_ns(random));
    times.add(ns);
    all_us.push_back(static_cast<double>(ns) / 1e3);
  }
  std::sort(all_us.begin(), all_us.end());
  for (const double fraction : {0.01, 0.25, 0.5, 0.9, 0.99, 1.0}) {
    const double truth = all_us[static_cast<std::size_t>(std::ceil(fraction * 20001.0)) - 1];
    CHECK(times.percentile_us(fraction) >= truth);
    CHECK(times.percentile_us(fraction) <= truth * 1.0321 + 0.001);
  }
  CHECK(times.max_us() == Approx(all_us.back()));
}

TEST_CASE("extreme durations stay inside the table", "[mapper][stage_times]") {
  StageTimes times;
  times.add(-5);  // a clock that stepped back counts as nothing
  times.add(0);
  times.add(INT64_MAX);
  CHECK(times.count() == 3);
  CHECK(times.percentile_us(0.5) == 0.0);
  CHECK(times.max_us() == Approx(static_cast<double>(INT64_MAX) / 1e3));
  CHECK(times.percentile_us(1.0) == Approx(static_cast<double>(INT64_MAX) / 1e3));
}
