// SPDX-License-Identifier: Apache-2.0
// What a person wants to know after a run: how much became map, how fast, and where it lies.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mapper/report.hpp"

namespace g3d::mapper {

struct WrittenFile {
  std::string path;
  std::string what;  ///< "native map", "OctoMap with colours" ...
  std::uint64_t bytes = 0;
};

/// "1.5 MB": powers of 1000, two digits at least.
[[nodiscard]] std::string readable_bytes(std::uint64_t bytes);
/// "12,345,678"
[[nodiscard]] std::string readable_count(std::uint64_t count);
/// A table of a few lines that ends with a new line.
[[nodiscard]] std::string summary_text(const RunReport& report, double run_s, const std::vector<WrittenFile>& files);

}  // namespace g3d::mapper
