// SPDX-License-Identifier: Apache-2.0
#include "net/set_sketch_wire.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <limits>

namespace g3d::net {

namespace {

constexpr std::uint32_t kSketchMostItems = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kSketchMostSymbol_bytes = 8 + 4 + 5;

std::int64_t expected_sketch_count(std::uint32_t items, std::size_t index) {
  const SymbolDensity density = symbol_density(static_cast<std::uint32_t>(index));
  return static_cast<std::int64_t>(items * density.numerator / density.denominator);
}

/// Small numbers of either sign -> small numbers: 0, -1, 1, -2 .. -> 0, 1, 2, 3 ..
std::uint64_t sketch_zigzag(std::int64_t value) {
  return static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
}
std::int64_t sketch_unzigzag(std::uint64_t value) { return static_cast<std::int64_t>(value >> 1 ^ (0 - (value & 1))); }

/// Appends to memory that is large enough.
class SketchWriter {
 public:
  explicit SketchWriter(std::uint8_t* begin) : begin_(begin), at_(begin) {}
  template <typename T>
  void put(T value) {
    std::memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }
  void put_varint(std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7) put(static_cast<std::uint8_t>(value | 0x80U));
    put(static_cast<std::uint8_t>(value));
  }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(at_ - begin_); }

 private:
  std::uint8_t* begin_;
  std::uint8_t* at_;
};

SketchFault take_sketch_number(mapper::ByteSpan bytes, mapper::ByteReader& in, std::uint64_t& value) {
  constexpr std::size_t kLongest_bytes = 9;
  const std::size_t begin = in.offset();
  if (!in.take_varint(value)) return in.left() < kLongest_bytes ? SketchFault::truncated : SketchFault::bad_number;
  const bool is_longer_than_need_be = bytes[in.offset() - 1] == 0 && in.offset() > begin + 1;
  return is_longer_than_need_be ? SketchFault::bad_number : SketchFault::none;
}

SketchFault take_sketch_symbol(mapper::ByteSpan bytes, mapper::ByteReader& in, std::uint32_t items, std::size_t index,
                               SketchSymbol& symbol) {
  if (!in.take(symbol.id_xor) || !in.take(symbol.check_xor)) return SketchFault::truncated;
  std::uint64_t zigzag = 0;
  const SketchFault fault = take_sketch_number(bytes, in, zigzag);
  if (fault != SketchFault::none) return fault;
  // A varint has at most 63 bits: no sum here comes near the limits of 64.
  const std::int64_t count = expected_sketch_count(items, index) + sketch_unzigzag(zigzag);
  if (count < 0 || count > items || (index == 0 && count != items)) return SketchFault::impossible_count;
  symbol.count = static_cast<std::int32_t>(count);
  return count == 0 && !symbol.is_zero() ? SketchFault::impossible_sum : SketchFault::none;
}

}  // namespace

const char* to_string(SketchFault fault) {
  switch (fault) {
    case SketchFault::none:
      return "none";
    case SketchFault::truncated:
      return "truncated";
    case SketchFault::no_symbols:
      return "no symbols";
    case SketchFault::too_many_symbols:
      return "too many symbols";
    case SketchFault::index_beyond_end:
      return "index beyond the end";
    case SketchFault::too_many_items:
      return "too many items";
    case SketchFault::bad_number:
      return "bad number";
    case SketchFault::impossible_count:
      return "impossible count";
    case SketchFault::impossible_sum:
      return "impossible sum";
    case SketchFault::trailing_bytes:
      return "trailing bytes";
  }
  return "?";
}

SketchWritten write_sketch(const SketchHeader& header, std::span<const SketchSymbol> symbols,
                           std::span<std::uint8_t> out) {
  assert(header.items <= kSketchMostItems && header.first + symbols.size() <= kMostSketchSymbols);
  std::array<std::uint8_t, kSketchHeader_bytes + kMostSymbolsPerMessage * kSketchMostSymbol_bytes> message;
  SketchWriter writer(message.data());
  writer.put(header.salt.low);
  writer.put(header.salt.high);
  writer.put(header.first);
  writer.put(header.items);
  writer.put(std::uint8_t{0});
  SketchWritten written;
  for (const SketchSymbol& symbol : symbols.first(std::min(symbols.size(), kMostSymbolsPerMessage))) {
    writer.put(symbol.id_xor);
    writer.put(symbol.check_xor);
    writer.put_varint(
        sketch_zigzag(symbol.count - expected_sketch_count(header.items, header.first + written.symbols)));
    if (writer.size() > out.size()) break;
    written = {writer.size(), written.symbols + 1};
  }
  message[kSketchHeader_bytes - 1] = static_cast<std::uint8_t>(written.symbols);
  std::copy_n(message.begin(), written.bytes, out.begin());
  return written;
}

SketchFault read_sketch(mapper::ByteSpan bytes, SketchMessage& message) {
  mapper::ByteReader in(bytes);
  SketchMessage read;
  std::uint8_t count = 0;
  SketchHeader& header = read.header;
  if (!in.take(header.salt.low) || !in.take(header.salt.high) || !in.take(header.first) || !in.take(header.items) ||
      !in.take(count)) {
    return SketchFault::truncated;
  }
  if (count == 0) return SketchFault::no_symbols;
  if (count > kMostSymbolsPerMessage) return SketchFault::too_many_symbols;
  if (header.first > kMostSketchSymbols - count) return SketchFault::index_beyond_end;
  if (header.items > kSketchMostItems) return SketchFault::too_many_items;
  for (std::size_t i = 0; i < count; ++i) {
    const SketchFault fault = take_sketch_symbol(bytes, in, header.items, header.first + i, read.symbols[i]);
    if (fault != SketchFault::none) return fault;
  }
  if (in.left() > 0) return SketchFault::trailing_bytes;
  read.symbol_count = count;
  message = read;
  return SketchFault::none;
}

}  // namespace g3d::net
