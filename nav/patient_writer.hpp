// SPDX-License-Identifier: Apache-2.0
// Writes files of a run that is over, one after the other, and tries again what failed: a disk may be full, read-only
// or pulled out for a while, and what a robot has seen is in memory alone until one of them takes it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"
#include "mapper/summary.hpp"

namespace g3d::nav {

/// One file, or two that belong together.
struct OutputJob {
  std::string path;
  std::function<hal::Result<mapper::WrittenFile>()> write;
};

struct Outputs {
  std::vector<mapper::WrittenFile> files;
  std::vector<hal::Error> failures;  ///< of the files that could not be written; the others are there
  std::uint64_t map_file_bytes = 0;  ///< of map.g3d
  int late_files = 0;                ///< there, but not at the first try
};

struct Patience {
  double seconds = 0.0;  ///< from the first failure; 0: every file is tried once
  hal::Clock* clock = nullptr;
  std::function<void(const hal::Error& first)> on_wait;  ///< told once, before the first wait. May be empty
  std::function<bool()> is_given_up;                     ///< by a person. May be empty
};

/// Files stand in the order of the jobs, whenever they were written. What no patience helps (a format that is unknown,
/// a file that is too large) is tried once.
[[nodiscard]] Outputs write_patiently(const std::vector<OutputJob>& jobs, const Patience& patience = {});

}  // namespace g3d::nav
