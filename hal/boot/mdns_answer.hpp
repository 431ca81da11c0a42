// SPDX-License-Identifier: Apache-2.0
// NAME.local for everybody on the same network: answers multicast DNS questions for our own IPv4 address (RFC 6762),
// and nothing else. Plain: datagram in, datagram out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace g3d::hal::boot {

inline constexpr std::uint32_t kMdnsGroup_ipv4 = 0xE00000FB;  ///< 224.0.0.251
inline constexpr std::uint16_t kMdnsPort = 5353;

/// Host name without ".local".
struct MdnsHost {
  std::string_view name;
  std::uint32_t ipv4 = 0;  ///< host byte order
};

struct MdnsAnswer {
  std::size_t size_bytes = 0;  ///< in `out`; 0: there is nothing to say
  bool goes_to_asker = false;  ///< straight to who has asked: a plain DNS question, or one that wants it so
};

/// `from_mdns_port`: the question came from port 5353; others are answered as plain DNS would (section 6.7). Questions
/// that are malformed, or longer than 16 questions, have no answer.
[[nodiscard]] MdnsAnswer answer_mdns(std::span<const std::uint8_t> question, bool from_mdns_port, const MdnsHost& host,
                                     std::span<std::uint8_t> out);
/// What is told when an address is new (section 8.3).
[[nodiscard]] std::size_t announce_mdns(const MdnsHost& host, std::span<std::uint8_t> out);

}  // namespace g3d::hal::boot
