// SPDX-License-Identifier: Apache-2.0
// The fleet key as a file: a few lines of text that only their owner may read. Written as a whole or not at all.
//
//   g3dmap fleet key 1
//   epoch 8
//   key 64 hexadecimal digits
//   previous 64 hexadecimal digits      the key of epoch 7, while a rotation goes on
//   revoked 00000000deadbeef            one line per robot
//   dropped 00000000deadbeef            the same, of robots whose layers are thrown away as well
//
// Blank lines and those that begin with # say nothing. One thread; errors name file, line and remedy, never the key.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "hal/result.hpp"
#include "net/fleet_key.hpp"
#include "net/private_text.hpp"

namespace g3d::net {

inline constexpr std::size_t kMostKeyFile_bytes = PrivateText::kMost_bytes;

/// `name` stands in errors. Errors: malformed, out_of_range, unsupported (a later version), truncated.
[[nodiscard]] hal::Result<FleetKey> parse_fleet_key(std::string_view text, const std::string& name);
/// What parse_fleet_key reads; the caller wipes it.
[[nodiscard]] std::string format_fleet_key(const FleetKey& keys);

/// Errors: as above; no_permission if anybody but the owner may read or write the file, or it is another user's.
[[nodiscard]] hal::Result<FleetKey> read_fleet_key(const std::string& path);
/// Mode 0600 from the first byte on. Replaces what is there.
[[nodiscard]] hal::Result<void> write_fleet_key(const std::string& path, const FleetKey& keys);

}  // namespace g3d::net
