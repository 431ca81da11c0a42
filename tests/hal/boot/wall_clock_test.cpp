// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/wall_clock.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal::boot;

TEST_CASE("time of day never goes back behind what was saved, or behind the program itself", "[boot]") {
  CHECK(believable_time_s(2'000'000'000, 1'900'000'000, 1'800'000'000) == 2'000'000'000);
  CHECK(believable_time_s(0, 1'900'000'000, 1'800'000'000) == 1'900'000'000);  // no battery
  CHECK(believable_time_s(0, 0, 1'800'000'000) == 1'800'000'000);
  CHECK(believable_time_s(1'000'000'000, INT64_MAX, 0) == 1'000'000'000);  // a file of chance
  CHECK(believable_time_s(5, -1, 0) == 5);
}

TEST_CASE("the time is saved whole, and nonsense is not read", "[boot]") {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/clock";
  CHECK(read_saved_time_s(path) == 0);
  REQUIRE(save_time(path, 1'900'000'000).ok());
  CHECK(read_saved_time_s(path) == 1'900'000'000);
  for (const char* text : {"", "x", "-5", "99999999999999999999", "5000000000", "12 3", "0"}) {
    test::write_plain(path, std::string_view(text));
    CHECK(read_saved_time_s(path) == 0);
  }
}
