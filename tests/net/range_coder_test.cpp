// SPDX-License-Identifier: Apache-2.0
#include "net/range_coder.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::net;

namespace {

struct Symbol {
  std::uint16_t probability;
  bool bit;
};

std::vector<std::uint8_t> coded(const std::vector<Symbol>& symbols, std::uint8_t first_byte) {
  std::vector<std::uint8_t> out(symbols.size() * 2 + 16);
  RangeEncoder coder;
  coder.open(out, first_byte);
  for (const Symbol& s : symbols) {
    BitModel model{s.probability};
    (void)coder.code(model, s.bit);
  }
  out.resize(coder.finish());
  return out;
}

bool comes_back(const std::vector<Symbol>& symbols, mapper::ByteSpan bytes, std::uint8_t first_byte) {
  RangeDecoder coder;
  coder.open(bytes, first_byte);
  for (const Symbol& s : symbols) {
    BitModel model{s.probability};
    if (coder.code(model, false) != s.bit) return false;
  }
  return coder.at_end();
}

/// Of every kind of probability, the bits mostly as these say.
std::vector<Symbol> some_symbols(tests::Random& random, std::size_t count) {
  std::vector<Symbol> symbols(count);
  const std::uint32_t kind = random.below(4);
  for (Symbol& s : symbols) {
    const std::uint32_t p = kind == 0 ? 16 : kind == 1 ? 65519 : kind == 2 ? 32768 : 16 + random.below(65504);
    s.probability = static_cast<std::uint16_t>(p);
    s.bit = random.below(65536) < p;
    if (random.below(50) == 0) s.bit = !s.bit;
  }
  return symbols;
}

}  // namespace

TEST_CASE("Bits of any probability come back, and the first byte is not below the one given") {
  tests::Random random(1);
  for (int i = 0; i < 3000; ++i) {
    const auto first_byte = static_cast<std::uint8_t>(1 + random.below(255));
    const std::vector<Symbol> symbols = some_symbols(random, random.below(300));
    const std::vector<std::uint8_t> bytes = coded(symbols, first_byte);
    REQUIRE_FALSE(bytes.empty());
    REQUIRE(bytes[0] >= first_byte);
    REQUIRE(comes_back(symbols, bytes, first_byte));
  }
}

TEST_CASE("A message takes as many bytes as it tells, rounded up") {
  tests::Random random(2);
  for (int i = 0; i < 200; ++i) {
    const std::vector<Symbol> symbols = some_symbols(random, 400);
    double bits = -std::log2(220.0 / 256.0);
    for (const Symbol& s : symbols) bits -= std::log2((s.bit ? s.probability : 65536 - s.probability) / 65536.0);
    REQUIRE(static_cast<double>(coded(symbols, 36).size()) <= bits / 8 + 1.6);
  }
}

TEST_CASE("A message that was cut, prolonged or has zeros at its end is none") {
  tests::Random random(3);
  for (int i = 0; i < 300; ++i) {
    const std::vector<Symbol> symbols = some_symbols(random, 1 + random.below(300));
    std::vector<std::uint8_t> bytes = coded(symbols, 36);
    REQUIRE(bytes.back() != 0);
    REQUIRE_FALSE(comes_back(symbols, mapper::ByteSpan(bytes).first(bytes.size() - 1), 36));
    bytes.push_back(0);
    REQUIRE_FALSE(comes_back(symbols, bytes, 36));
    bytes.back() = static_cast<std::uint8_t>(1 + random.below(255));
    REQUIRE_FALSE(comes_back(symbols, bytes, 36));
  }
}

TEST_CASE("What does not fit is not written") {
  tests::Random random(4);
  std::vector<Symbol> symbols(800, Symbol{32768, true});
  for (Symbol& s : symbols) s.bit = random.below(2) == 0;
  const std::size_t needed = coded(symbols, 1).size();
  for (std::size_t room = 0; room <= needed; ++room) {
    std::vector<std::uint8_t> out(room + 1, 0xAB);
    RangeEncoder coder;
    coder.open(std::span(out).first(room), 1);
    for (const Symbol& s : symbols) {
      BitModel model{s.probability};
      (void)coder.code(model, s.bit);
    }
    REQUIRE(coder.finish() == (room == needed ? needed : 0));
    REQUIRE(out.back() == 0xAB);
  }
}

TEST_CASE("Plain bits come back") {
  std::array<std::uint8_t, 64> out{};
  RangeEncoder encoder;
  encoder.open(out, 7);
  for (std::uint32_t i = 0; i < 40; ++i) (void)encoder.code_plain(i * 37 & 0x1FFU, 9);
  const std::size_t size = encoder.finish();
  CHECK(size <= 46);
  RangeDecoder decoder;
  decoder.open(mapper::ByteSpan(out).first(size), 7);
  for (std::uint32_t i = 0; i < 40; ++i) REQUIRE(decoder.code_plain(0, 9) == (i * 37 & 0x1FFU));
  CHECK(decoder.at_end());
}

TEST_CASE("The shortest number lies in its interval, whatever that is") {
  tests::Random random(5);
  for (int i = 0; i < 100'000; ++i) {
    std::uint64_t low = random.next() >> random.below(64);
    std::uint64_t high = random.next() >> random.below(64);
    if (low > high) std::swap(low, high);
    std::uint64_t number = 0;
    const int count = bytes_of_shortest(low, high, number);
    REQUIRE(number >= low);
    REQUIRE(number <= high);
    if (count < 8) REQUIRE(number << (8 * count) == 0);
  }
}
