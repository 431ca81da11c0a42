// SPDX-License-Identifier: Apache-2.0
// Where a datagram comes from or goes to: an IPv4 address and a port, in numbers and as people write them. No names:
// what a resolver says is another's word, and takes its time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace g3d::hal {

struct Ipv4Endpoint {
  std::uint32_t ipv4 = 0;  ///< as a number: 10.0.0.2 is 0x0A000002
  std::uint16_t port = 0;
  bool operator==(const Ipv4Endpoint&) const = default;
};

/// "10.0.0.2": four decimal numbers without signs, spaces or leading zeros.
[[nodiscard]] std::optional<std::uint32_t> parse_ipv4(std::string_view text);
/// "10.0.0.2:4711"; the port is 1 to 65535.
[[nodiscard]] std::optional<Ipv4Endpoint> parse_ipv4_endpoint(std::string_view text);
/// "10.0.0.2:4711".
[[nodiscard]] std::string to_string(const Ipv4Endpoint& endpoint);

[[nodiscard]] constexpr bool is_multicast(std::uint32_t ipv4) { return ipv4 >> 28 == 0xE; }

}  // namespace g3d::hal
