// SPDX-License-Identifier: Apache-2.0
#include "nav/explained.hpp"

namespace g3d::nav {

std::string_view name_of(LeftReason reason) {
  static constexpr std::array<std::string_view, kLeftReasons> kNames = {
      "too_small", "out_of_sight", "unreachable", "outside_area", "fruitless", "blocked", "energy"};
  return kNames[static_cast<std::size_t>(reason)];
}

}  // namespace g3d::nav
