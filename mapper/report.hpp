// SPDX-License-Identifier: Apache-2.0
// What a run says about itself: report.json. delivered = integrated + all dropped, always.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"
#include "mapper/align/align_report.hpp"
#include "mapper/align/motion_prior.hpp"
#include "mapper/stage_times.hpp"
#include "mapper/submaps/loop_report.hpp"

namespace g3d::mapper {

class JsonWriter;

struct FrameCounts {
  std::uint64_t delivered = 0;   ///< by the camera, usable or not
  std::uint64_t integrated = 0;  ///< in the map
  std::array<std::uint64_t, hal::kDropReasonCount> dropped{};

  [[nodiscard]] std::uint64_t dropped_total() const;
  [[nodiscard]] bool balanced() const { return delivered == integrated + dropped_total(); }
};

struct NamedStage {
  std::string name;
  StageTimes times;
};

/// What the rolling window did.
struct PagingReport {
  double radius_m = 0.0;           ///< while memory suffices
  double smallest_radius_m = 0.0;  ///< to which lack of memory shrank it
  std::uint64_t regions_out = 0;
  std::uint64_t regions_in = 0;
  std::uint64_t blocks_out = 0;
  std::uint64_t blocks_in = 0;
  std::uint64_t regions_on_disk = 0;  ///< at the end
  std::uint64_t submaps_out = 0;      ///< with loops: that went to disk as a whole ...
  std::uint64_t submaps_in = 0;       ///< ... and came back for a while
  std::uint64_t submaps_on_disk = 0;  ///< at the end
  std::uint64_t late_regions = 0;     ///< seen before they were back, then merged
  std::uint64_t failed_stores = 0;    ///< those regions stayed in memory
  std::uint64_t failed_loads = 0;     ///< those regions are lost
  std::uint64_t page_file_bytes = 0;
};

/// How the poses were corrected.
struct AlignmentReport {
  align::OdometryMode odometry = align::OdometryMode::aligned;
  align::Motion motion = align::Motion::planar;
  align::AlignReport counts;
};

struct RunReport {
  FrameCounts frames;
  std::vector<NamedStage> stages;

  // the map
  std::string mapper = "cpu";
  double resolution_m = 0.0;
  std::uint64_t occupied = 0;
  std::uint64_t free = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t refused_blocks = 0;  ///< for lack of memory, summed over the frames
  std::optional<PagingReport> paging;
  std::uint64_t file_bytes = 0;  ///< of map.g3d
  std::string hash;

  std::optional<AlignmentReport> alignment;    ///< none: the poses were taken as given
  std::optional<submaps::CloserReport> loops;  ///< none: nobody looked for them

  // the run
  std::string command;
  std::string version;
  std::uint64_t seed = 0;
  int threads = 1;
  std::string board;
  std::function<void(JsonWriter&)> write_more;  ///< further members, between the map and the run
  std::vector<std::string> notes;  ///< what the user should know: an interruption, a full pool, a camera error
};

[[nodiscard]] std::string to_json(const RunReport& report);

}  // namespace g3d::mapper
