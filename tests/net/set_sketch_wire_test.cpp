// SPDX-License-Identifier: Apache-2.0
#include "net/set_sketch_wire.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <string>

#include "hal/sim/seeded_random.hpp"

using namespace g3d;
using namespace g3d::net;
using mapper::Bytes;

namespace {

constexpr std::size_t kSketchDatagram_bytes = 1200;

struct SketchOfItems {
  SketchOfItems(std::uint32_t items, std::uint32_t first, std::size_t count) : symbols(count) {
    hal::SeededRandom random(items + 1);
    header = {{random.bits(), random.bits()}, first, items};
    SketchEncoder encoder(header.salt, first, symbols);
    for (std::uint32_t n = 0; n < items; ++n) encoder.add(random.bits());
  }
  [[nodiscard]] Bytes bytes() const {
    Bytes out(kSketchHeader_bytes + symbols.size() * 17);
    const SketchWritten written = write_sketch(header, symbols, out);
    REQUIRE(written.symbols == symbols.size());
    out.resize(written.bytes);
    return out;
  }
  SketchHeader header;
  std::vector<SketchSymbol> symbols;
};

/// A message of one symbol, each part as one likes.
Bytes made_sketch(std::uint32_t first, std::uint32_t items, std::uint8_t symbol_count, std::uint64_t id_xor,
                  std::uint32_t check_xor, const Bytes& number) {
  Bytes out;
  mapper::put(out, std::uint64_t{1});
  mapper::put(out, std::uint64_t{2});
  mapper::put(out, first);
  mapper::put(out, items);
  mapper::put(out, symbol_count);
  mapper::put(out, id_xor);
  mapper::put(out, check_xor);
  mapper::put_bytes(out, number);
  return out;
}

SketchFault fault_of(const Bytes& bytes) {
  SketchMessage message;
  message.header.first = 77;
  message.symbol_count = 1;
  message.symbols[0] = {1, 2, 3};
  const SketchFault fault = read_sketch(bytes, message);
  if (fault != SketchFault::none) {
    CHECK(message.header == SketchHeader{{}, 77, 0});
    CHECK(message.symbol_count == 1);
    CHECK(message.symbols[0] == SketchSymbol{1, 2, 3});
  }
  return fault;
}

}  // namespace

TEST_CASE("symbols come back from their bytes", "[net][sketch]") {
  const std::uint32_t items = GENERATE(0U, 1U, 5U, 3000U);
  const std::uint32_t first = GENERATE(0U, 1U, 128U, 100000U, kMostSketchSymbols - 128);
  const std::size_t count = GENERATE(1U, 128U);
  const SketchOfItems sketch(items, first, count);
  SketchMessage message;
  REQUIRE(read_sketch(sketch.bytes(), message) == SketchFault::none);
  CHECK(message.header == sketch.header);
  CHECK(std::ranges::equal(message.used(), sketch.symbols));
}

TEST_CASE("the bytes are those that they have always been", "[net][sketch]") {
  const std::vector<SketchSymbol> symbols{{0x0807060504030201ULL, 0x0C0B0A09U, 1000}, {0, 0, 0}, {1, 2, 439}};
  Bytes out(100);
  const SketchWritten written = write_sketch({{0x1111111111111111ULL, 0x2222222222222222ULL}, 0, 1000}, symbols, out);
  CHECK(written.symbols == 3);
  out.resize(written.bytes);
  Bytes expected(8, 0x11);
  expected.insert(expected.end(), 8, 0x22);
  // 555 of 1000 items are expected in symbol 1, 437 in symbol 2.
  for (const int byte : {0, 0, 0, 0, 0xE8, 3, 0, 0, 3, 1,    2,    3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 0, 0,
                         0, 0, 0, 0, 0,    0, 0, 0, 0, 0xD5, 0x08, 1, 0, 0, 0, 0, 0, 0, 0,  2,  0,  0, 0, 4}) {
    expected.push_back(static_cast<std::uint8_t>(byte));
  }
  CHECK(out == expected);
}

TEST_CASE("a datagram holds 83 symbols of 10^6 items, and no more than fit are written", "[net][sketch]") {
  const SketchOfItems sketch(1'000'000, 0, 128);
  Bytes out(kSketchDatagram_bytes, 0xEE);
  const SketchWritten written = write_sketch(sketch.header, sketch.symbols, out);
  CHECK(written.symbols >= 83);
  CHECK(written.bytes <= out.size());
  SketchMessage message;
  REQUIRE(read_sketch(mapper::ByteSpan(out).first(written.bytes), message) == SketchFault::none);
  CHECK(std::ranges::equal(message.used(), std::span(sketch.symbols).first(written.symbols)));

  for (std::size_t room = 0; room < 80; ++room) {
    std::ranges::fill(out, std::uint8_t{0xEE});
    const SketchWritten few = write_sketch(sketch.header, sketch.symbols, std::span(out).first(room));
    CHECK(few.bytes <= room);
    CHECK((few.bytes == 0) == (few.symbols == 0));
    CHECK(std::ranges::all_of(std::span(out).subspan(few.bytes), [](std::uint8_t byte) { return byte == 0xEE; }));
  }
  CHECK(write_sketch(sketch.header, {}, out).bytes == 0);
}

TEST_CASE("a sketch that goes over the wire in parts is decoded", "[net][sketch]") {
  hal::SeededRandom random(5);
  const SketchSalt salt{random.bits(), random.bits()};
  std::vector<SketchId> ours(5000);
  for (SketchId& id : ours) id = random.bits();
  const std::vector<SketchId> peers(ours.begin() + 150, ours.end());
  SketchDecoder decoder(200);
  decoder.start(salt);
  std::vector<SketchSymbol> symbols(83);
  Bytes datagram(kSketchDatagram_bytes);
  std::size_t sent_bytes = 0;
  for (std::uint32_t first = 0; decoder.state() == SketchState::wants_symbols;) {
    SketchEncoder(salt, first, symbols).add(peers);
    const SketchHeader header{salt, first, static_cast<std::uint32_t>(peers.size())};
    const SketchWritten written = write_sketch(header, symbols, datagram);
    sent_bytes += written.bytes;
    SketchMessage message;
    REQUIRE(read_sketch(mapper::ByteSpan(datagram).first(written.bytes), message) == SketchFault::none);
    SketchEncoder(salt, first, symbols).add(ours);
    (void)decoder.add(first, std::span(symbols).first(message.symbol_count), message.used());
    first += static_cast<std::uint32_t>(written.symbols);
  }
  CHECK(decoder.state() == SketchState::complete);
  CHECK(decoder.only_ours().size() == 150);
  CHECK(decoder.only_peers().empty());
  CHECK(sent_bytes < 4 * kSketchDatagram_bytes);
}

TEST_CASE("a message cut anywhere is truncated", "[net][sketch]") {
  const Bytes whole = SketchOfItems(3000, 0, 3).bytes();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CHECK(fault_of(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))) == SketchFault::truncated);
  }
  Bytes longer = whole;
  longer.push_back(0);
  CHECK(fault_of(longer) == SketchFault::trailing_bytes);
}

TEST_CASE("what no sketch can be is refused with its reason", "[net][sketch]") {
  CHECK(fault_of(made_sketch(0, 9, 1, 5, 6, {0})) == SketchFault::none);
  CHECK(fault_of(made_sketch(0, 9, 0, 5, 6, {0})) == SketchFault::no_symbols);
  CHECK(fault_of(made_sketch(0, 9, 129, 5, 6, {0})) == SketchFault::too_many_symbols);
  CHECK(fault_of(made_sketch(kMostSketchSymbols - 1, 9, 1, 5, 6, {2})) == SketchFault::none);
  CHECK(fault_of(made_sketch(kMostSketchSymbols, 9, 1, 5, 6, {2})) == SketchFault::index_beyond_end);
  CHECK(fault_of(made_sketch(0xFFFFFFFFU, 9, 1, 5, 6, {2})) == SketchFault::index_beyond_end);
  CHECK(fault_of(made_sketch(0, 0x7FFFFFFFU, 1, 5, 6, {0})) == SketchFault::none);
  CHECK(fault_of(made_sketch(0, 0x80000000U, 1, 5, 6, {0})) == SketchFault::too_many_items);

  // Symbol 0 has all 9, symbol 1 as a rule 5.
  CHECK(fault_of(made_sketch(0, 9, 1, 5, 6, {1})) == SketchFault::impossible_count);
  CHECK(fault_of(made_sketch(0, 9, 1, 5, 6, {2})) == SketchFault::impossible_count);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, {8})) == SketchFault::none);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, {10})) == SketchFault::impossible_count);
  CHECK(fault_of(made_sketch(1, 9, 1, 0, 0, {9})) == SketchFault::none);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 0, {9})) == SketchFault::impossible_sum);
  CHECK(fault_of(made_sketch(1, 9, 1, 0, 6, {9})) == SketchFault::impossible_sum);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, {11})) == SketchFault::impossible_count);

  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, {0x82, 0})) == SketchFault::bad_number);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, Bytes(10, 0x80))) == SketchFault::bad_number);
  Bytes greatest(8, 0xFF);
  greatest.push_back(0x7F);
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, greatest)) == SketchFault::impossible_count);
  greatest[0] = 0xFE;
  CHECK(fault_of(made_sketch(1, 9, 1, 5, 6, greatest)) == SketchFault::impossible_count);
}

TEST_CASE("every fault of a sketch has a name", "[net][sketch]") {
  for (int i = 0; i <= static_cast<int>(SketchFault::trailing_bytes); ++i) {
    CHECK(std::string(to_string(static_cast<SketchFault>(i))) != "?");
  }
  CHECK(std::string(to_string(static_cast<SketchFault>(99))) == "?");
}
