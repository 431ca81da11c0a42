// SPDX-License-Identifier: Apache-2.0
// What a run says about itself: report.json. delivered = integrated + all dropped, always.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"
#include "mapper/stage_times.hpp"

namespace g3d::mapper {

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

struct RunReport {
  FrameCounts frames;
  std::vector<NamedStage> stages;

  // the map
  std::string mapper = "cpu";
  double resolution_m = 0.0;
  std::uint64_t occupied = 0;
  std::uint64_t free = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t file_bytes = 0;  ///< of map.g3d
  std::string hash;

  // the run
  std::string command;
  std::string version;
  std::uint64_t seed = 0;
  int threads = 1;
  std::string board;
  std::vector<std::string> notes;  ///< what the user should know: an interruption, a full pool, a camera error
};

[[nodiscard]] std::string to_json(const RunReport& report);

}  // namespace g3d::mapper
