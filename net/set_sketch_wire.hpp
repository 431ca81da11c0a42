// SPDX-License-Identifier: Apache-2.0
// Symbols of a set sketch as the bytes of a datagram, little-endian: salt u64 u64 | first u32 | items u32 | symbols u8,
// then for each symbol: ids xored u64 | checks xored u32 | count less what is expected of so many items, as a zigzag
// varint. So a symbol takes 13 or 14 bytes, and one of 1200 bytes holds 83 or more.
// Thread: any. Allocates nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "mapper/files/bytes.hpp"
#include "net/set_sketch.hpp"

namespace g3d::net {

struct SketchHeader {
  SketchSalt salt;
  std::uint32_t first = 0;  ///< index of the first symbol
  std::uint32_t items = 0;  ///< in the set; 2^31 - 1 at most
  friend bool operator==(const SketchHeader&, const SketchHeader&) = default;
};

inline constexpr std::size_t kSketchHeader_bytes = 25;
inline constexpr std::size_t kMostSymbolsPerMessage = 128;

struct SketchMessage {
  SketchHeader header;
  std::size_t symbol_count = 0;
  std::array<SketchSymbol, kMostSymbolsPerMessage> symbols;
  [[nodiscard]] std::span<const SketchSymbol> used() const { return std::span(symbols).first(symbol_count); }
};

struct SketchWritten {
  std::size_t bytes = 0;
  std::size_t symbols = 0;  ///< the first so many of those given
};
/// Writes as many of the symbols as fit in one message and in `out`; nothing if that is none. Precondition: the symbols
/// are those of one set, by a SketchEncoder.
[[nodiscard]] SketchWritten write_sketch(const SketchHeader& header, std::span<const SketchSymbol> symbols,
                                         std::span<std::uint8_t> out);

enum class SketchFault : std::uint8_t {
  none,
  truncated,         ///< ends before what it announces
  no_symbols,        ///< announces none
  too_many_symbols,  ///< announces more than kMostSymbolsPerMessage
  index_beyond_end,  ///< symbols at or after kMostSketchSymbols
  too_many_items,    ///< more than can be counted
  bad_number,        ///< a varint that is longer than it need be, or than any
  impossible_count,  ///< a symbol of more or fewer items than the set can have in it
  impossible_sum,    ///< a symbol without items that is not zero
  trailing_bytes,    ///< more bytes than announced
};
[[nodiscard]] const char* to_string(SketchFault fault);

/// `message` is left as it was unless the fault is none. What is accepted is written to the same bytes again.
[[nodiscard]] SketchFault read_sketch(mapper::ByteSpan bytes, SketchMessage& message);

}  // namespace g3d::net
