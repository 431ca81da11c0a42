// SPDX-License-Identifier: Apache-2.0
#include "mapper/summary.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d;
using namespace g3d::mapper;

TEST_CASE("bytes and counts are readable", "[mapper][summary]") {
  CHECK(readable_bytes(0) == "0 B");
  CHECK(readable_bytes(999) == "999 B");
  CHECK(readable_bytes(1000) == "1.0 kB");
  CHECK(readable_bytes(1'549'000) == "1.5 MB");
  CHECK(readable_bytes(999'600) == "1.0 MB");
  CHECK(readable_bytes(123'400'000) == "123 MB");
  CHECK(readable_count(0) == "0");
  CHECK(readable_count(999) == "999");
  CHECK(readable_count(1000) == "1,000");
  CHECK(readable_count(12345678) == "12,345,678");
}

TEST_CASE("the summary says frames, drops, map and files", "[mapper][summary]") {
  RunReport report;
  report.frames.delivered = 100;
  report.frames.integrated = 97;
  report.frames.dropped[static_cast<std::size_t>(hal::DropReason::no_pose)] = 2;
  report.frames.dropped[static_cast<std::size_t>(hal::DropReason::bad_pose)] = 1;
  report.resolution_m = 0.02;
  report.occupied = 1234;
  report.free = 56789;
  report.memory_bytes = 2'000'000;
  report.notes = {"interrupted"};
  CHECK(summary_text(report, 2.0, {{"out/map.g3d", "native map", 1500}, {"out/a", "short", 7}}) ==
        "mapped     97 of 100 frames in 2.0 s, 48.5 frames/s\n"
        "dropped    2 no_pose, 1 bad_pose\n"
        "map        1,234 occupied and 56,789 free voxels of 2 cm, 2.0 MB of memory\n"
        "note       interrupted\n"
        "files      out/map.g3d    1.5 kB  native map\n"
        "           out/a             7 B  short\n");
}
