// SPDX-License-Identifier: Apache-2.0
// Places that a robot sees again: what the newest submap and the one before have shown is fitted to what was shown
// around an older one, starting from where the graph has both, or, if that finds nothing, from how both look. A fit
// counts only if it is found again with less to go by: the newest submap alone, fitted to fewer of the old ones, has to
// stand at the same place. Thread: one. Allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "mapper/align/map_aligner.hpp"
#include "mapper/submaps/loop_report.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

struct FinderOptions {
  std::size_t least_age = 4;        ///< submaps between: what is younger is aligned to frame by frame
  double most_distance_m = 5.0;     ///< between the anchors, as far as is known
  std::size_t most_candidates = 2;  ///< for each submap
  double reach_m = 1.0;             ///< how far off the graph may be
  double reach_rad = 0.25;
  double least_likeness = 0.75;  ///< of a place that is tried wherever the graph has it, if none of the others fits
  double likeness_reach_m = 2.0;
  double likeness_reach_rad = 0.3;
  double most_apart_m = 0.06;  ///< between the two fits
  double most_apart_rad = 0.015;
};

struct Loop {
  std::uint32_t from = 0;  ///< submaps
  std::uint32_t to = 0;
  hal::Pose T_from_to;  ///< of their anchors
  double hold = 0.5;    ///< see MapAlignment
};

/// How far two submaps are from each other in the chain.
[[nodiscard]] constexpr std::uint32_t submaps_apart(std::uint32_t a, std::uint32_t b) { return a > b ? a - b : b - a; }

class LoopFinder {
 public:
  explicit LoopFinder(const FinderOptions& options = {}) : options_(options) {}

  /// Of the newest submap.
  [[nodiscard]] std::vector<Loop> find(const SubmapChain& chain);
  [[nodiscard]] const FinderReport& report() const { return report_; }

 private:
  struct Candidate {
    std::uint32_t submap = 0;
    hal::Pose T_guess;  ///< the newest's anchor in its
    double reach_m = 0.0;
    double reach_rad = 0.0;
  };
  [[nodiscard]] std::vector<Candidate> near_candidates(const SubmapChain& chain) const;
  [[nodiscard]] std::optional<Candidate> alike_candidate(const SubmapChain& chain,
                                                         const std::vector<Candidate>& tried) const;

  FinderOptions options_;
  FinderReport report_;
};

}  // namespace g3d::mapper::submaps
