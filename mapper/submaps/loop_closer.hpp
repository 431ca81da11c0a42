// SPDX-License-Identifier: Apache-2.0
// Brings the chain of submaps to where its loops say it should be: a node for each submap, an edge for the way between
// two of them, an edge for each loop. One fit alone is not believed, however good: halls and rows of rooms look alike.
// A loop enters the graph when another one, of another submap nearby, says the same of the way in between (pairwise
// consistency: Mangelsen et al. 2018). Thread: one. Allocates.
#pragma once

#include <cstdint>
#include <vector>

#include "mapper/submaps/loop_finder.hpp"
#include "mapper/submaps/pose_graph.hpp"
#include "mapper/submaps/submap_chain.hpp"

namespace g3d::mapper::submaps {

/// Standard deviations of the way from one anchor to the next, after alignment.
struct WayNoise {
  double shift_m = 0.01;
  double shift_per_m = 0.004;
  double shift_m_per_held_s = 0.008;  ///< while odometry alone knew the way
  double turn_rad = 0.004;
  double turn_per_rad = 0.002;
  double turn_rad_per_held_s = 0.006;
};

struct CloserOptions {
  FinderOptions finder;
  WayNoise way;
  /// Of a loop that is held alike from all sides.
  double loop_sigma_m = 0.03;
  double loop_sigma_rad = 0.01;
  std::uint32_t most_submaps_apart = 6;  ///< between two loops that speak for each other
  double most_off_m = 0.08;              ///< of their cycle
  double most_off_rad = 0.03;
  double least_move_m = 0.08;  ///< of any submap; else the view is left as it is
  double least_turn_rad = 0.025;
  bool on_floor = false;  ///< submaps are moved along the floor and turned about the vertical, and nothing else
};

class LoopCloser {
 public:
  explicit LoopCloser(const CloserOptions& options = {}) : options_(options), finder_(options.finder) {}

  /// After every finish_submap(). True: the poses have moved, see T_world_stored().
  [[nodiscard]] bool add_submap(const SubmapChain& chain);
  /// The same without looking for loops, right after poses have moved: the newest submap goes along with the one
  /// before.
  void add_following(const SubmapChain& chain);
  /// A submap and the next, neither of them the newest, have become one: see SubmapChain::join().
  void join(std::uint32_t submap, const hal::Pose& T_next_one);
  /// For SubmapChain::place().
  [[nodiscard]] const std::vector<hal::Pose>& T_world_stored() const { return T_world_stored_; }

  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] CloserReport report() const;

 private:
  [[nodiscard]] bool speaks_for(const Loop& a, const Loop& b) const;
  void add_to_graph(const Loop& loop);
  void add_way(const SubmapChain& chain);
  [[nodiscard]] hal::Pose stored_pose(const Submap& submap, const hal::Pose& T_world_anchor) const;

  CloserOptions options_;
  LoopFinder finder_;
  PoseGraph graph_;
  std::vector<Loop> alone_;
  std::vector<hal::Pose> T_world_stored_;
  std::uint64_t joined_ = 0;
  std::uint64_t corrections_ = 0;
  double largest_move_m_ = 0.0;
};

}  // namespace g3d::mapper::submaps
