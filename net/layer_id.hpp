// SPDX-License-Identifier: Apache-2.0
// Who wrote a part of the shared map: one robot from one start of its counter of versions to the next. A robot that
// comes back without that counter begins a new incarnation, so that no version ever names two contents.
#pragma once

#include <compare>
#include <cstdint>

namespace g3d::net {

using RobotId = std::uint64_t;
/// Counts what a writer has published in one layer, from 1. 0: nothing.
using Version = std::uint64_t;

struct LayerId {
  RobotId robot = 0;
  std::uint32_t incarnation = 0;
  auto operator<=>(const LayerId&) const = default;
};

/// Every bit of the result depends on every bit of both. For digests and priorities, not for secrets.
[[nodiscard]] constexpr std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9E3779B97F4A7C15ULL ^ (b + 0xD1B54A32D192ED03ULL) * 0x8CB92BA72F3D8DD7ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}
[[nodiscard]] constexpr std::uint64_t mixed(const LayerId& id) { return mixed(id.robot, id.incarnation); }

/// A layer's short name in messages between robots that both know the whole one. A store holds no two layers of the
/// same short name.
using LayerAlias = std::uint32_t;
[[nodiscard]] constexpr LayerAlias alias_of(const LayerId& id) { return static_cast<LayerAlias>(mixed(id)); }
/// A robot's short name in a message to everybody that has a part for each. Two of the same take each other's.
using RobotAlias = std::uint32_t;
[[nodiscard]] constexpr RobotAlias alias_of(RobotId robot) { return static_cast<RobotAlias>(mixed(robot, 0)); }

}  // namespace g3d::net
