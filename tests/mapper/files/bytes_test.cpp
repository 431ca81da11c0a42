// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/bytes.hpp"

#include <catch2/catch.hpp>

using namespace g3d::mapper;

TEST_CASE("Numbers come back, lowest byte first") {
  Bytes bytes;
  put(bytes, std::uint32_t{0x11223344});
  put(bytes, -1.5F);
  CHECK(bytes[0] == 0x44);
  ByteReader in(bytes);
  std::uint32_t number = 0;
  float real = 0;
  REQUIRE(in.take(number));
  REQUIRE(in.take(real));
  CHECK(number == 0x11223344);
  CHECK(real == -1.5F);
  CHECK(in.left() == 0);
}

TEST_CASE("A take past the end fails and changes nothing") {
  const Bytes bytes(3, 7);
  ByteReader in(bytes);
  std::uint32_t number = 99;
  ByteSpan span;
  CHECK_FALSE(in.take(number));
  CHECK_FALSE(in.take_bytes(4, span));
  CHECK_FALSE(in.take_bytes(~std::size_t{0}, span));
  CHECK(number == 99);
  CHECK(in.offset() == 0);
  CHECK(in.take_bytes(3, span));
  CHECK(span.size() == 3);
}

TEST_CASE("Varints of every length come back") {
  for (int bits = 0; bits < 63; ++bits) {
    for (const std::uint64_t value : {(std::uint64_t{1} << bits) - 1, std::uint64_t{1} << bits}) {
      Bytes bytes;
      put_varint(bytes, value);
      ByteReader in(bytes);
      std::uint64_t read = 0;
      REQUIRE(in.take_varint(read));
      REQUIRE(read == value);
      REQUIRE(in.left() == 0);
      ByteReader cut(ByteSpan(bytes).first(bytes.size() - 1));
      REQUIRE_FALSE(cut.take_varint(read));
    }
  }
  const Bytes endless(20, 0x80);
  ByteReader in(endless);
  std::uint64_t value = 0;
  CHECK_FALSE(in.take_varint(value));
}
