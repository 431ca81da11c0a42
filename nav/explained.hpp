// SPDX-License-Identifier: Apache-2.0
// Why a frontier was left unexplored. An exploration is done only when every frontier that remains has one of these.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace g3d::nav {

enum class LeftReason : std::uint8_t {
  too_small,     ///< no reachable pose would show more than a few unknown cells there
  out_of_sight,  ///< no place that the body can take, at the camera's near and far limit, faces it
  unreachable,   ///< it would be seen from free places, but none of them is connected to the robot at this footprint
  outside_area,  ///< beyond the area limit
  fruitless,     ///< looked at it often enough, and it stayed unknown
  blocked,       ///< goals towards it failed often enough
  energy,        ///< the battery is needed for the way home
};
inline constexpr std::size_t kLeftReasons = 7;

[[nodiscard]] std::string_view name_of(LeftReason reason);

/// Clusters of frontier cells by reason, and how many are still to be explored.
struct FrontiersLeft {
  std::array<std::uint32_t, kLeftReasons> clusters{};
  std::uint32_t open = 0;  ///< not explained (yet)

  [[nodiscard]] std::uint32_t& operator[](LeftReason reason) { return clusters[static_cast<std::size_t>(reason)]; }
  [[nodiscard]] std::uint32_t operator[](LeftReason reason) const { return clusters[static_cast<std::size_t>(reason)]; }
  bool operator==(const FrontiersLeft&) const = default;
};

}  // namespace g3d::nav
