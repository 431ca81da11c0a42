// SPDX-License-Identifier: Apache-2.0
#include "net/fleet_key.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace g3d::net {

bool FleetKey::has_revoked(std::uint64_t robot) const {
  return std::find(revoked.begin(), revoked.end(), robot) != revoked.end();
}

bool FleetKey::has_dropped(std::uint64_t robot) const {
  return std::find(dropped.begin(), dropped.end(), robot) != dropped.end();
}

FleetKey generate_fleet_key() {
  FleetKey keys;
  keys.epoch = 1;
  keys.key = SecretKey::random();
  return keys;
}

void rotate_fleet_key(FleetKey& keys, OldKey old_key) {
  SecretKey before = std::exchange(keys.key, SecretKey::random());
  ++keys.epoch;
  keys.previous.reset();
  if (old_key == OldKey::kept_until_finished) keys.previous = std::move(before);
}

void finish_rotation(FleetKey& keys) { keys.previous.reset(); }

hal::Result<void> revoke_robot(FleetKey& keys, std::uint64_t robot) {
  if (keys.has_revoked(robot)) return {};
  if (keys.revoked.size() >= FleetKey::kMostRevoked) {
    return hal::Error{hal::Reason::no_capacity,
                      fmt::format("{} robots are revoked already, which is the limit; rotate the key with --shut-out "
                                  "and remove old ids from the file",
                                  keys.revoked.size())};
  }
  keys.revoked.push_back(robot);
  return {};
}

hal::Result<void> drop_robot(FleetKey& keys, std::uint64_t robot) {
  if (!keys.has_dropped(robot) && keys.dropped.size() >= FleetKey::kMostRevoked) {
    return hal::Error{
        hal::Reason::no_capacity,
        fmt::format("the layers of {} robots are dropped already, which is the limit; rotate the key with "
                    "--shut-out and remove old ids from the file",
                    keys.dropped.size())};
  }
  if (const hal::Result<void> revoked = revoke_robot(keys, robot); !revoked) return revoked;
  if (!keys.has_dropped(robot)) keys.dropped.push_back(robot);
  return {};
}

std::optional<std::uint64_t> parse_robot_id(std::string_view text) {
  std::uint64_t robot = 0;
  const char* const end = text.data() + text.size();
  if (text.empty() || text.size() > 16) return std::nullopt;
  const auto [stopped, failed] = std::from_chars(text.data(), end, robot, 16);
  if (failed != std::errc{} || stopped != end) return std::nullopt;
  return robot;
}

}  // namespace g3d::net
