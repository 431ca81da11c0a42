// SPDX-License-Identifier: Apache-2.0
// Where the robot's body has been and when, in steps of a few centimetres: a correction of the map moves each of them
// by itself. Memory for so many is provided at construction; when it is full, every second of them is forgotten, so
// that the whole way stays, more coarsely. One thread.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "nav/move_field.hpp"
#include "nav/planar_algebra.hpp"

namespace g3d::nav {

class TroddenWay {
 public:
  static constexpr double kStep_m = 0.04;
  static constexpr std::size_t kMost = 1U << 15;  // 1.3 km

  TroddenWay() { way_.reserve(kMost); }

  void tread(const Trodden& here) {
    if (!way_.empty() && std::hypot(here.x_m - way_.back().x_m, here.y_m - way_.back().y_m) < kStep_m) return;
    if (way_.size() == kMost) thin();
    way_.push_back(here);
  }
  void move(const mapper::submaps::ChainMove& move) {
    for (Trodden& place : way_) place = moved(place, on_plane(move.at(place.at_ns)));
  }
  /// Oldest first.
  [[nodiscard]] std::span<const Trodden> places() const { return way_; }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < way_.size(); i += 2) way_[kept++] = way_[i];
    way_.resize(kept);
  }

  std::vector<Trodden> way_;
};

}  // namespace g3d::nav
