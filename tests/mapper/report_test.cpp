// SPDX-License-Identifier: Apache-2.0
#include "mapper/report.hpp"

#include <catch2/catch.hpp>

using namespace g3d;
using mapper::FrameCounts;
using mapper::RunReport;

namespace {
bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
}  // namespace

TEST_CASE("frame counts balance only when every frame is accounted for", "[mapper][report]") {
  FrameCounts frames;
  frames.delivered = 10;
  frames.integrated = 7;
  frames.dropped[static_cast<std::size_t>(hal::DropReason::no_pose)] = 2;
  CHECK_FALSE(frames.balanced());
  frames.dropped[static_cast<std::size_t>(hal::DropReason::queue_full)] = 1;
  CHECK(frames.balanced());
  CHECK(frames.dropped_total() == 3);
}

TEST_CASE("the report has the members that readers rely on", "[mapper][report]") {
  RunReport report;
  report.frames.delivered = 3;
  report.frames.integrated = 2;
  report.frames.dropped[static_cast<std::size_t>(hal::DropReason::bad_pose)] = 1;
  report.stages.push_back({"integrate", {}});
  report.stages.back().times.add(1500000);
  report.resolution_m = 0.05;
  report.occupied = 11;
  report.free = 22;
  report.memory_bytes = 33;
  report.file_bytes = 44;
  report.hash = "ab12";
  report.refused_blocks = 6;
  report.command = "g3dmap replay \"my log\"";
  report.version = "v1";
  report.seed = 5;
  report.threads = 2;
  report.board = "laptop";
  report.notes = {"interrupted"};
  const std::string json = to_json(report);
  CHECK(contains(json, "\"delivered\": 3"));
  CHECK(contains(json, "\"integrated\": 2"));
  CHECK(contains(json, "\"bad_pose\": 1"));
  CHECK(contains(json, "\"queue_full\": 0"));
  CHECK(contains(json, "\"integrate\": {\n      \"p50\": 1500,\n      \"p99\": 1500,\n      \"max\": 1500\n    }"));
  CHECK(contains(
      json,
      "\"map\": {\n    \"mapper\": \"cpu\",\n    \"resolution_m\": 0.05,\n    \"occupied\": 11,\n    \"free\": 22,\n"
      "    \"memory_bytes\": 33,\n    \"file_bytes\": 44,\n    \"hash\": \"ab12\",\n    \"refused_blocks\": 6\n  }"));
  CHECK(contains(json, R"("command": "g3dmap replay \"my log\"")"));
  CHECK(contains(json, "\"version\": \"v1\",\n    \"seed\": 5,\n    \"threads\": 2,\n    \"board\": \"laptop\""));
  CHECK(contains(json, "\"interrupted\"\n    ]"));
}

TEST_CASE("what was paged out stands in the report only if there was a window", "[mapper][report]") {
  RunReport report;
  CHECK_FALSE(contains(to_json(report), "regions_out"));
  report.paging = mapper::PagingReport{.radius_m = 12.3456,
                                       .smallest_radius_m = 8.0,
                                       .regions_out = 5,
                                       .regions_in = 4,
                                       .blocks_out = 500,
                                       .blocks_in = 400,
                                       .regions_on_disk = 1,
                                       .submaps_out = 14,
                                       .submaps_in = 13,
                                       .submaps_on_disk = 12,
                                       .late_regions = 2,
                                       .failed_stores = 3,
                                       .failed_loads = 6,
                                       .page_file_bytes = 777};
  CHECK(contains(to_json(report),
                 "\"window\": {\n      \"radius_m\": 12.346,\n      \"smallest_radius_m\": 8,\n"
                 "      \"regions_out\": 5,\n      \"regions_in\": 4,\n      \"blocks_out\": 500,\n"
                 "      \"blocks_in\": 400,\n      \"regions_on_disk\": 1,\n      \"late_regions\": 2,\n"
                 "      \"submaps_out\": 14,\n      \"submaps_in\": 13,\n      \"submaps_on_disk\": 12,\n"
                 "      \"failed_stores\": 3,\n      \"failed_loads\": 6,\n      \"page_file_bytes\": 777\n"));
}
