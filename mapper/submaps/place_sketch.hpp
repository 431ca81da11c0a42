// SPDX-License-Identifier: Apache-2.0
// What a place looks like, to be recognised without knowing where it is: how high what stands there reaches, by
// distance and direction (after Kim and Kim 2018, "Scan Context"). Turned by whole sectors it is the same place seen by
// a robot that faces elsewhere. A camera sees a part of the directions; only those that both have seen are compared.
// Thread: any. Allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "hal/geometry.hpp"
#include "mapper/align/depth_sample.hpp"

namespace g3d::mapper::submaps {

class PlaceSketch {
 public:
  static constexpr int kRings = 12;
  static constexpr int kSectors = 60;
  static constexpr float kRing_m = 0.5F;
  static constexpr float kLevel_m = 0.15F;
  static constexpr int kLeastSectors = 15;  ///< that both have seen, or nothing is known

  PlaceSketch() = default;
  /// `surfaces` in any frame whose z is up, about a point of it. What lies is left out: floors are everywhere.
  PlaceSketch(std::span<const align::DepthSample> surfaces, const align::Vector3f& centre_m);

  struct Likeness {
    double share = 0.0;     ///< 0..1
    double turn_rad = 0.0;  ///< by which the other place has to be turned to look like this one
  };
  [[nodiscard]] Likeness likeness(const PlaceSketch& other) const;

 private:
  using Column = std::array<float, kRings>;  ///< of one sector: levels, as a vector of length 1
  std::array<Column, kSectors> columns_{};
  std::array<bool, kSectors> is_seen_{};
};

}  // namespace g3d::mapper::submaps
