// SPDX-License-Identifier: Apache-2.0
// The two messages by which a sender proves that it speaks now. Sealed like any other datagram, little-endian:
//
//   challenge  u8 1 | u64 nonce | u64 the session that is to prove itself
//   response   u8 2 | u64 nonce of the challenge | u64 robot | u64 incarnation
//
// A challenge names the session so that nobody else can be made to answer it. Plain; nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

namespace g3d::net {

struct Challenge {
  std::uint64_t nonce = 0;
  std::uint64_t session = 0;
  bool operator==(const Challenge&) const = default;
};

struct Response {
  std::uint64_t nonce = 0;
  std::uint64_t robot = 0;
  std::uint64_t incarnation = 0;  ///< how often this robot has started, or whatever else tells its starts apart
  bool operator==(const Response&) const = default;
};

inline constexpr std::size_t kChallenge_bytes = 1 + 8 + 8;
inline constexpr std::size_t kResponse_bytes = 1 + 8 + 8 + 8;

[[nodiscard]] std::array<std::uint8_t, kChallenge_bytes> encode(const Challenge& challenge);
[[nodiscard]] std::array<std::uint8_t, kResponse_bytes> encode(const Response& response);

using HandshakeMessage = std::variant<Challenge, Response>;
/// Nothing unless the bytes are exactly one message.
[[nodiscard]] std::optional<HandshakeMessage> decode_handshake(std::span<const std::uint8_t> bytes);

}  // namespace g3d::net
