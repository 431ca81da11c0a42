// SPDX-License-Identifier: Apache-2.0
// What a way of exploring did on a floor plan, and what it is compared by.
#pragma once

#include <string>

#include "tests/support/flat_sim.hpp"

namespace g3d::tests {

struct FlatResult {
  double t90_s = -1.0;  ///< time to that share of what is observable, -1: never
  double t95_s = -1.0;
  double t99_s = -1.0;
  double end_s = 0.0;
  double coverage = 0.0;
  double path_m = 0.0;
  double turned_rad = 0.0;
  int contacts = 0;
  bool ended = false;  ///< by itself, not by the time limit
  bool home = false;
  int goals = 0;
  std::string left;  ///< frontiers left, by reason
};

/// To be called after every step.
inline void note_progress(const FlatSim& sim, FlatResult& result) {
  const double c = sim.coverage();
  if (result.t90_s < 0 && c >= 0.90) result.t90_s = sim.time_s();
  if (result.t95_s < 0 && c >= 0.95) result.t95_s = sim.time_s();
  if (result.t99_s < 0 && c >= 0.99) result.t99_s = sim.time_s();
}

inline void note_end(const FlatSim& sim, FlatResult& result) {
  result.end_s = sim.time_s();
  result.coverage = sim.coverage();
  result.path_m = sim.path_m();
  result.turned_rad = sim.turned_rad();
  result.contacts = sim.contacts();
}

}  // namespace g3d::tests
