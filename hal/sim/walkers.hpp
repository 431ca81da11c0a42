// SPDX-License-Identifier: Apache-2.0
// The people of a world, walking among robots. They follow their waypoints; who ends where he began walks the round
// again and again. Nobody walks into a robot: 0.4 m before one they stop, and who has waited for long goes back the way
// he came.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "hal/messages.hpp"
#include "hal/sim/world.hpp"

namespace g3d::hal {

class Walkers {
 public:
  static constexpr double kDistance_m = 0.4;  ///< from surface to surface
  static constexpr double kPatience_s = 3.0;

  /// The first `count` movers of the world are people. `world` must outlive this.
  Walkers(const World& world, std::size_t count);

  /// Allocates nothing. `robots_m`: where discs of `robot_radius_m` stand.
  void step(double dt_s, std::span<const std::array<float, 2>> robots_m, double robot_radius_m);
  [[nodiscard]] std::array<float, 2> place_m(std::size_t i) const { return walkers_[i].place_m; }
  [[nodiscard]] std::size_t count() const { return walkers_.size(); }

 private:
  struct Walker {
    double radius_m = 0.0;
    double begin_s = 0.0;
    double end_s = 0.0;
    bool in_rounds = false;
    double own_time_s = 0.0;  ///< along his waypoints
    double direction = 1.0;
    double waited_s = 0.0;
    std::array<float, 2> place_m{};
  };

  [[nodiscard]] double advanced(const Walker& walker, double dt_s) const;

  const World& world_;
  std::vector<Walker> walkers_;
};

}  // namespace g3d::hal
