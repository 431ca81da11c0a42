// SPDX-License-Identifier: Apache-2.0
#include "net/handshake_message.hpp"

#include <bit>
#include <cstring>

namespace g3d::net {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian; all our targets are, too");
constexpr std::uint8_t kChallengeMark = 1, kResponseMark = 2;

void put_handshake_number(std::uint8_t* at, std::uint64_t number) { std::memcpy(at, &number, sizeof(number)); }

std::uint64_t handshake_number(const std::uint8_t* at) {
  std::uint64_t number = 0;
  std::memcpy(&number, at, sizeof(number));
  return number;
}

}  // namespace

std::array<std::uint8_t, kChallenge_bytes> encode(const Challenge& challenge) {
  std::array<std::uint8_t, kChallenge_bytes> bytes;
  bytes[0] = kChallengeMark;
  put_handshake_number(&bytes[1], challenge.nonce);
  put_handshake_number(&bytes[9], challenge.session);
  return bytes;
}

std::array<std::uint8_t, kResponse_bytes> encode(const Response& response) {
  std::array<std::uint8_t, kResponse_bytes> bytes;
  bytes[0] = kResponseMark;
  put_handshake_number(&bytes[1], response.nonce);
  put_handshake_number(&bytes[9], response.robot);
  put_handshake_number(&bytes[17], response.incarnation);
  return bytes;
}

std::optional<HandshakeMessage> decode_handshake(std::span<const std::uint8_t> bytes) {
  if (bytes.size() == kChallenge_bytes && bytes[0] == kChallengeMark) {
    return Challenge{handshake_number(&bytes[1]), handshake_number(&bytes[9])};
  }
  if (bytes.size() == kResponse_bytes && bytes[0] == kResponseMark) {
    return Response{handshake_number(&bytes[1]), handshake_number(&bytes[9]), handshake_number(&bytes[17])};
  }
  return std::nullopt;
}

}  // namespace g3d::net
