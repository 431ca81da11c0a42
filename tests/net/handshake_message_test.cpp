// SPDX-License-Identifier: Apache-2.0
#include "net/handshake_message.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

namespace {

using namespace g3d::net;

constexpr Challenge kChallenge{0x0102030405060708, 0x1112131415161718};
constexpr Response kResponse{0x0102030405060708, 0x2122232425262728, 0x3132333435363738};

TEST_CASE("messages go through bytes") {
  const auto challenge = decode_handshake(encode(kChallenge));
  REQUIRE(challenge);
  CHECK(std::get<Challenge>(*challenge) == kChallenge);
  const auto response = decode_handshake(encode(kResponse));
  REQUIRE(response);
  CHECK(std::get<Response>(*response) == kResponse);
}

TEST_CASE("bytes are those of the documentation") {
  const auto bytes = encode(kChallenge);
  CHECK(std::vector<int>(bytes.begin(), bytes.end()) ==
        std::vector<int>{1, 8, 7, 6, 5, 4, 3, 2, 1, 0x18, 0x17, 0x16, 0x15, 0x14, 0x13, 0x12, 0x11});
  CHECK(encode(kResponse)[0] == 2);
  CHECK(encode(kResponse)[24] == 0x31);
}

TEST_CASE("nothing but exactly a message is one") {
  for (std::size_t size = 0; size < 64; ++size) {
    for (int mark = 0; mark < 256; ++mark) {
      std::vector<std::uint8_t> bytes(size, 0x55);
      if (size > 0) bytes[0] = static_cast<std::uint8_t>(mark);
      const bool is_one = (size == kChallenge_bytes && mark == 1) || (size == kResponse_bytes && mark == 2);
      REQUIRE(decode_handshake(bytes).has_value() == is_one);
    }
  }
}

}  // namespace
