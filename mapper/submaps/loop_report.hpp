// SPDX-License-Identifier: Apache-2.0
// What became of the places that looked like being seen again: for report.json.
#pragma once

#include <cstdint>

namespace g3d::mapper::submaps {

struct FinderReport {
  std::uint64_t tried = 0;
  std::uint64_t alike = 0;      ///< of these: for how they look, wherever the graph had them
  std::uint64_t refused = 0;    ///< no fit that is sure by itself
  std::uint64_t not_again = 0;  ///< a fit that was not found again with less
  std::uint64_t found = 0;
};

struct CloserReport {
  FinderReport finder;
  std::uint64_t submaps = 0;
  std::uint64_t joined = 0;  ///< old ones that have become part of the one before
  std::uint64_t edges = 0;
  std::uint64_t loops = 0;        ///< in the graph
  std::uint64_t alone = 0;        ///< that nobody speaks for (yet)
  std::uint64_t disbelieved = 0;  ///< in the graph, but it contradicts the others
  std::uint64_t corrections = 0;  ///< how often the map was moved
  double largest_move_m = 0.0;
  std::uint64_t memory_bytes = 0;    ///< of the submaps
  std::uint64_t refused_blocks = 0;  ///< that the map had no memory for when it was made anew
};

}  // namespace g3d::mapper::submaps
