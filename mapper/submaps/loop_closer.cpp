// SPDX-License-Identifier: Apache-2.0
#include "mapper/submaps/loop_closer.hpp"

#include <algorithm>
#include <cmath>

#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::submaps {
namespace {

constexpr double kBelieved = 0.5;
constexpr double kHeldAlike = 0.5;

}  // namespace

void LoopCloser::add_way(const SubmapChain& chain) {
  const auto submaps = chain.submaps();
  const Submap& newest = submaps.back();
  const std::size_t before = graph_.nodes().size();
  if (before == 0) {
    graph_.add_node(newest.T_world_anchor());
    return;
  }
  const hal::Pose step = hal::compose(hal::inverse(submaps[before - 1].T_world_anchor()), newest.T_world_anchor());
  const std::uint32_t node = graph_.add_node(hal::compose(graph_.nodes()[before - 1], step));
  const WayNoise& noise = options_.way;
  EdgeSigma sigma;
  sigma.floor_m = noise.shift_m + noise.shift_per_m * newest.way_m + noise.shift_m_per_held_s * newest.held_s;
  sigma.heading_rad = noise.turn_rad + noise.turn_per_rad * newest.turn_rad + noise.turn_rad_per_held_s * newest.held_s;
  graph_.add_edge({node - 1, node, step, information_of(sigma), false});
}

// Around the cycle of two loops and the two pieces of way between their ends one comes back to where one started.
bool LoopCloser::speaks_for(const Loop& a, const Loop& b) const {
  if (a.to == b.to || submaps_apart(a.to, b.to) > options_.most_submaps_apart ||
      submaps_apart(a.from, b.from) > options_.most_submaps_apart) {
    return false;
  }
  const auto nodes = graph_.nodes();
  const hal::Pose T_from = hal::compose(hal::inverse(nodes[b.from]), nodes[a.from]);
  const hal::Pose T_to = hal::compose(hal::inverse(nodes[a.to]), nodes[b.to]);
  const hal::Pose expected = hal::compose(hal::compose(T_from, a.T_from_to), T_to);
  const align::Vector6 off = align::difference(expected, b.T_from_to);
  return align::shift_of(off) <= options_.most_off_m && align::turn_of(off) <= options_.most_off_rad;
}

void LoopCloser::add_to_graph(const Loop& loop) {
  EdgeSigma sigma;
  // Along a corridor little stands across the way, and says less.
  sigma.floor_m = options_.loop_sigma_m * std::sqrt(kHeldAlike / loop.hold);
  sigma.heading_rad = options_.loop_sigma_rad;
  graph_.add_edge({loop.from, loop.to, loop.T_from_to, information_of(sigma), true});
}

void LoopCloser::join(std::uint32_t submap, const hal::Pose& T_next_one) {
  std::erase_if(alone_, [&](Loop& loop) { return !join_ends(loop, submap, T_next_one); });
  graph_.join(submap, T_next_one);
  ++joined_;
}

hal::Pose LoopCloser::stored_pose(const Submap& submap, const hal::Pose& T_world_anchor) const {
  hal::Pose pose = hal::compose(T_world_anchor, hal::inverse(submap.T_stored_anchor));
  if (!options_.on_floor) return pose;
  pose.translation_m[2] = 0.0;
  pose.rotation_xyzw[0] = pose.rotation_xyzw[1] = 0.0;
  return hal::normalised(pose);
}

void LoopCloser::add_following(const SubmapChain& chain) {
  add_way(chain);
  T_world_stored_.push_back(stored_pose(chain.submaps().back(), graph_.nodes().back()));
}

bool LoopCloser::add_submap(const SubmapChain& chain) {
  add_way(chain);
  bool is_news = false;
  for (const Loop& loop : finder_.find(chain)) {
    const auto speaks = [&](const Loop& other) { return speaks_for(other, loop); };
    const auto first = std::partition(alone_.begin(), alone_.end(), [&](const Loop& other) { return !speaks(other); });
    const auto edges = graph_.edges();
    const bool is_backed = first != alone_.end() || std::any_of(edges.begin(), edges.end(), [&](const GraphEdge& edge) {
                             return edge.is_loop && speaks({edge.from, edge.to, edge.T_from_to});
                           });
    if (!is_backed) {
      alone_.push_back(loop);
      continue;
    }
    for (auto other = first; other != alone_.end(); ++other) add_to_graph(*other);
    alone_.erase(first, alone_.end());
    add_to_graph(loop);
    is_news = true;
  }
  if (!is_news || !graph_.optimise().solved) return false;

  const auto submaps = chain.submaps();
  T_world_stored_.clear();
  double move_m = 0.0;
  double turn_rad = 0.0;
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const align::Vector6 off = align::difference(submaps[i].T_world_anchor(), graph_.nodes()[i]);
    move_m = std::max(move_m, align::shift_of(off));
    turn_rad = std::max(turn_rad, align::turn_of(off));
    T_world_stored_.push_back(stored_pose(submaps[i], graph_.nodes()[i]));
  }
  if (move_m < options_.least_move_m && turn_rad < options_.least_turn_rad) return false;
  ++corrections_;
  largest_move_m_ = std::max(largest_move_m_, move_m);
  return true;
}

CloserReport LoopCloser::report() const {
  CloserReport report;
  report.finder = finder_.report();
  report.submaps = graph_.nodes().size();
  report.edges = graph_.edges().size();
  report.joined = joined_;
  report.alone = alone_.size();
  for (const GraphEdge& edge : graph_.edges()) {
    report.loops += edge.is_loop ? 1 : 0;
    report.disbelieved += edge.is_loop && graph_.belief_in(edge) < kBelieved ? 1 : 0;
  }
  report.corrections = corrections_;
  report.largest_move_m = largest_move_m_;
  return report;
}

}  // namespace g3d::mapper::submaps
