// SPDX-License-Identifier: Apache-2.0
// Where the pieces of a map stand, out of how they stand to one another: nodes are poses, edges measurements between
// two of them. Sparse Gauss-Newton on the edges' information (Grisetti et al. 2010, "A Tutorial on Graph-Based SLAM").
// An edge that closes a loop may be wrong as a whole; the farther it is from what all others say, the less it counts
// (dynamic covariance scaling, Agarwal et al. 2013), so that one false recognition bends no map. What is far at first
// is believed all the same until the others have had their say (graduated, Yang et al. 2020): odometry may have
// gathered much by the time that a loop closes. The first node stays. Steps are bounded, and so is the time. Thread:
// one. Allocates: not for the way between camera and base.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/geometry.hpp"
#include "mapper/align/normal_equations.hpp"

namespace g3d::mapper::submaps {

struct GraphEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  hal::Pose T_from_to;           ///< as measured
  align::Matrix6 information{};  ///< of (shift, turn) in the frame of `to` as measured
  bool is_loop = false;          ///< may be wrong as a whole
};

/// Information of an edge whose errors are independent: standard deviations along the floor, in height, in tilt and in
/// heading. For a robot on a floor what the scene does not say is next to certain.
struct EdgeSigma {
  double floor_m = 0.02;
  double height_m = 0.005;
  double tilt_rad = 0.002;
  double heading_rad = 0.004;
};
[[nodiscard]] align::Matrix6 information_of(const EdgeSigma& sigma);
/// Of the same edge, measured to something that is fixed to `to`.
[[nodiscard]] align::Matrix6 information_at(const align::Matrix6& information, const hal::Pose& T_to_new);

/// What has `from`, `to` and T_from_to, after PoseGraph::join(). False: it has no two ends any more.
template <typename Edge>
[[nodiscard]] bool join_ends(Edge& edge, std::uint32_t node, const hal::Pose& T_next_node) {
  if (edge.to == node + 1) edge.T_from_to = hal::compose(edge.T_from_to, T_next_node);
  if (edge.from == node + 1) edge.T_from_to = hal::compose(hal::inverse(T_next_node), edge.T_from_to);
  edge.from -= edge.from > node ? 1 : 0;
  edge.to -= edge.to > node ? 1 : 0;
  return edge.from != edge.to;
}

struct GraphOptions {
  int most_steps = 8;      ///< for each degree of belief, of which there are some twenty at most
  double loop_phi = 10.0;  ///< squared standard deviations beyond which a loop counts less
};

struct GraphReport {
  int steps = 0;
  double cost_before = 0.0;  ///< squared standard deviations, loops scaled
  double cost_after = 0.0;
  bool solved = true;  ///< false: the equations could not be solved, and no node has moved
};

class PoseGraph {
 public:
  std::uint32_t add_node(const hal::Pose& T_world_node);
  /// Both nodes must be there.
  void add_edge(const GraphEdge& edge);

  /// The node after `node` becomes part of it and stands to it as T_next_node says from now on. What was measured to
  /// the one was measured to the other; what was measured between them is forgotten. Later nodes have one number less.
  void join(std::uint32_t node, const hal::Pose& T_next_node);

  GraphReport optimise(const GraphOptions& options = {});

  [[nodiscard]] std::span<const hal::Pose> nodes() const { return nodes_; }
  [[nodiscard]] std::span<const GraphEdge> edges() const { return edges_; }
  /// How far an edge is from where the nodes stand, in squared standard deviations.
  [[nodiscard]] double square_of(const GraphEdge& edge) const;
  /// How much it counts there: 1, or less for a loop that contradicts the others.
  [[nodiscard]] double belief_in(const GraphEdge& edge, const GraphOptions& options = {}) const {
    return scale_of(edge, options.loop_phi) * scale_of(edge, options.loop_phi);
  }

 private:
  [[nodiscard]] double cost(double phi) const;
  [[nodiscard]] double scale_of(const GraphEdge& edge, double phi) const;
  /// Steps until nothing moves any more; false if no step could be taken where one was needed.
  bool settle(double phi, const GraphOptions& options, int& steps);

  std::vector<hal::Pose> nodes_;
  std::vector<GraphEdge> edges_;
};

}  // namespace g3d::mapper::submaps
