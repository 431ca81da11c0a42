// SPDX-License-Identifier: Apache-2.0
#include "net/team_frame.hpp"

#include "nav/planar_algebra.hpp"

namespace g3d::net {
namespace {

void move(nav::WayPoint& point, const hal::PlanarPose& T_to_from) {
  const hal::PlanarPose moved = nav::compose(T_to_from, {point.x_m, point.y_m, 0.0});
  point.x_m = static_cast<float>(moved.x_m);
  point.y_m = static_cast<float>(moved.y_m);
}

/// Most maps stand where the world begins: nothing is to be rounded then.
bool is_nowhere_else(const hal::PlanarPose& T_to_from) { return T_to_from == hal::PlanarPose{}; }

}  // namespace

nav::TeamWord in_world(const nav::TeamWord& in_map, const hal::Pose& T_world_map) {
  const hal::PlanarPose T = nav::on_plane(T_world_map);
  nav::TeamWord word = in_map;
  if (is_nowhere_else(T)) return word;
  word.T_world_base = nav::compose(T, word.T_world_base);
  word.goal = nav::compose(T, word.goal);
  for (std::size_t i = 0; i < word.way_count; ++i) move(word.way[i], T);
  for (std::size_t i = 0; i < word.offer_count; ++i) word.offers[i].goal = nav::compose(T, word.offers[i].goal);
  return word;
}

nav::TeamSight in_map(const nav::TeamSight& in_world, const hal::Pose& T_world_map) {
  const hal::PlanarPose T = nav::inverse(nav::on_plane(T_world_map));
  nav::TeamSight sight = in_world;
  if (is_nowhere_else(T)) return sight;
  for (std::size_t i = 0; i < sight.count; ++i) {
    nav::Teammate& mate = sight.mates[i];
    mate.T_world_base = nav::compose(T, mate.T_world_base);
    mate.goal = nav::compose(T, mate.goal);
    for (std::size_t k = 0; k < mate.way_count; ++k) move(mate.way[k], T);
  }
  if (sight.assigned) sight.assigned = nav::compose(T, *sight.assigned);
  return sight;
}

}  // namespace g3d::net
