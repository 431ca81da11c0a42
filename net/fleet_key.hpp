// SPDX-License-Identifier: Apache-2.0
// What makes robots one fleet: a key that all of them share, numbered by its epoch. Whoever has it can speak as any of
// them, so the list of revoked robots stops honest copies only; a robot in wrong hands is shut out by a new key that it
// does not get. One thread; cold paths only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "hal/result.hpp"
#include "net/secret_key.hpp"

namespace g3d::net {

struct FleetKey {
  static constexpr std::size_t kMostRevoked = 256;

  std::uint16_t epoch = 0;
  SecretKey key;
  /// Of the epoch before, until all robots have the new one.
  std::optional<SecretKey> previous;
  /// Robots whose datagrams nobody takes any more; each once. What they had told before stays.
  std::vector<std::uint64_t> revoked;

  /// Robots whose layers are thrown away, from whomever they come; each once. Meant for revoked ones.
  std::vector<std::uint64_t> dropped;

  [[nodiscard]] bool has_revoked(std::uint64_t robot) const;
  [[nodiscard]] bool has_dropped(std::uint64_t robot) const;
  /// Epochs of one file are neighbours, so their low byte tells them apart on the wire.
  [[nodiscard]] std::uint16_t previous_epoch() const { return static_cast<std::uint16_t>(epoch - 1); }
};

/// Epoch 1.
[[nodiscard]] FleetKey generate_fleet_key();

enum class OldKey {
  kept_until_finished,  ///< robots that have only the old key go on talking with the others
  shut_out,             ///< nobody listens to it from now on: for a robot in wrong hands
};
/// A new key with the next epoch; 0 follows 65535.
void rotate_fleet_key(FleetKey& keys, OldKey old_key);
/// Forgets the key before, once every robot has the new one.
void finish_rotation(FleetKey& keys);
/// Also if it is revoked already. Errors: no_capacity.
[[nodiscard]] hal::Result<void> revoke_robot(FleetKey& keys, std::uint64_t robot);

/// Revokes it, and from now on nobody keeps what it has mapped. Errors: no_capacity; then nothing has changed.
[[nodiscard]] hal::Result<void> drop_robot(FleetKey& keys, std::uint64_t robot);

/// 1 to 16 hexadecimal digits, such as file and command line have them.
[[nodiscard]] std::optional<std::uint64_t> parse_robot_id(std::string_view text);

}  // namespace g3d::net
