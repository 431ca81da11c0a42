// SPDX-License-Identifier: Apache-2.0
#include "net/wire_parts.hpp"

#include <catch2/catch.hpp>

#include "tests/support/sample_maps.hpp"

using namespace g3d;

namespace {

net::LayerPosition random_position(tests::Random& random) {
  net::LayerPosition position{{random.next(), static_cast<std::uint32_t>(random.next())}, {}};
  for (net::VersionRanges& had : position.had) {
    net::Version version = random.next() % 100000;
    had = net::VersionRanges(version);
    for (std::uint32_t i = random.below(net::VersionRanges::kMostBeyond + 1); i > 0; --i) {
      const net::Version after = version + 1 + random.below(1000);
      version = after + 1 + random.below(1000);
      REQUIRE(had.add({after, version}));
    }
  }
  return position;
}

}  // namespace

TEST_CASE("a position is read as it was written, and no part of it is", "[net]") {
  tests::Random random(3);
  for (int i = 0; i < 200; ++i) {
    const net::LayerPosition position = random_position(random);
    net::WireWriter out;
    out.begin(7);
    REQUIRE(out.put_position(position));
    mapper::ByteReader in(out.bytes().subspan(1));
    net::LayerPosition read;
    REQUIRE(net::take_position(in, read) == net::MessageFault::none);
    CHECK(in.left() == 0);
    CHECK(read.id == position.id);
    CHECK(read.had == position.had);
    for (std::size_t bytes = 0; bytes + 1 < out.size(); ++bytes) {
      mapper::ByteReader cut(out.bytes().subspan(1, bytes));
      REQUIRE(net::take_position(cut, read) == net::MessageFault::truncated);
    }
  }
}

TEST_CASE("what does not fit a message is not begun", "[net]") {
  tests::Random random(4);
  net::WireWriter out;
  out.begin(7);
  std::size_t positions = 0;
  std::size_t size = out.size();
  while (out.put_position(random_position(random))) {
    ++positions;
    REQUIRE(out.size() > size);
    size = out.size();
    REQUIRE(size <= net::kMostMessage_bytes);
  }
  CHECK(out.size() == size);
  CHECK(positions > 3);
}

TEST_CASE("versions that nobody reaches and ranges that do not ascend are faults", "[net]") {
  const auto fault_of = [](std::initializer_list<std::uint64_t> numbers) {
    mapper::Bytes bytes(net::kLayerId_bytes, 1);
    for (const std::uint64_t number : numbers) mapper::put_varint(bytes, number);  // ranges of the first lane alone
    mapper::ByteReader in(bytes);
    net::LayerPosition position;
    return net::take_position(in, position);
  };
  CHECK(fault_of({0, 5, 0, 0}) == net::MessageFault::none);
  CHECK(fault_of({0, 5, 9, 10}) == net::MessageFault::none);       // 5, 0, 5
  CHECK(fault_of({0, 5, 11, 0}) == net::MessageFault::bad_range);  // 5, -1
  CHECK(fault_of({8, 5, 0, 0}) == net::MessageFault::bad_range);   // a fourth lane
  CHECK(fault_of({1, 5, 0, 0, 1, 2, 3}) == net::MessageFault::none);
  CHECK(fault_of({1, 5, 0, 0, 0}) == net::MessageFault::bad_range);  // has ranges, but none
  CHECK(fault_of({0, net::kMostVersion + 1, 0, 0}) == net::MessageFault::bad_range);
  CHECK(fault_of({0, net::kMostVersion, 2, 0}) == net::MessageFault::bad_range);
  CHECK(fault_of({1, 5, 0, 0, 1, 0, 3}) == net::MessageFault::bad_range);
  CHECK(fault_of({1, 5, 0, 0, 1, 2, 0}) == net::MessageFault::bad_range);
  CHECK(fault_of({1, 5, 0, 0, 1, 2, net::kMostVersion}) == net::MessageFault::bad_range);
  CHECK(fault_of({1, 5, 0, 0, net::VersionRanges::kMostBeyond + 1, 1, 1}) == net::MessageFault::too_many);
}

TEST_CASE("differences of keys are short either way", "[net]") {
  for (const std::int64_t difference : {0L, 1L, -1L, 63L, -64L, 1L << 54, -(1L << 54)}) {
    const auto wrapped = static_cast<std::uint64_t>(difference);
    CHECK(net::from_zigzag(net::zigzag(wrapped)) == wrapped);
  }
  CHECK(net::zigzag(static_cast<std::uint64_t>(-64L)) == 127);
}

TEST_CASE("a writer knows what room it has", "[net]") {
  net::WireWriter out;
  out.begin(1);
  CHECK(out.size() == 1);
  CHECK(out.has_room(net::kMostMessage_bytes - 1));
  CHECK_FALSE(out.has_room(net::kMostMessage_bytes));
  CHECK(out.rest().size() == net::kMostMessage_bytes - 1);
}
