// SPDX-License-Identifier: Apache-2.0
#include "net/block_plain.hpp"

#include <algorithm>

namespace g3d::net {
namespace {

using mapper::BlockValues;
using mapper::Rgbo;

/// Into memory that is known to be large enough.
class PlainWriter {
 public:
  explicit PlainWriter(std::span<std::uint8_t> out) : out_(out) {}
  void put(std::size_t byte) { out_[size_++] = static_cast<std::uint8_t>(byte); }
  void put_code(Rgbo code) {
    put(code & 0x7FU);
    if ((code & mapper::kHasColourBit) == 0) return;
    for (const int shift : {24, 16, 8}) put(code >> shift & 0xFFU);
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
};

std::size_t code_bytes(Rgbo code) { return (code & mapper::kHasColourBit) != 0 ? 4 : 1; }
std::size_t length_bytes(std::size_t run) { return run - 1 < 0x80U ? 1 : 2; }
std::size_t index_bits(std::size_t colours) { return colours <= 2 ? 1 : colours <= 4 ? 2 : 4; }

template <typename OnRun>
void for_each_run(const BlockValues& values, PlaceRange places, const OnRun& on_run) {
  for (std::size_t i = places.begin; i < places.end;) {
    std::size_t end = i + 1;
    while (end < places.end && values[end] == values[i]) ++end;
    on_run(values[i], end - i);
    i = end;
  }
}

struct Palette {
  std::array<Rgbo, kMaxPalette> codes{};
  std::size_t count = 0;
  [[nodiscard]] std::size_t find(Rgbo code) const {
    return static_cast<std::size_t>(std::find(codes.begin(), codes.begin() + count, code) - codes.begin());
  }
};

struct PlainSizes {
  std::size_t raw = 1;
  std::size_t runs = 1;
  std::size_t palette = 0;  ///< 0: more than 16 codes
  Palette codes;
};

PlainSizes measure_plain(const BlockValues& values, PlaceRange places) {
  PlainSizes sizes;
  bool few = true;
  for_each_run(values, places, [&](Rgbo code, std::size_t run) {
    sizes.raw += run * code_bytes(code);
    sizes.runs += length_bytes(run) + code_bytes(code);
    if (!few || sizes.codes.find(code) < sizes.codes.count) return;
    few = sizes.codes.count < kMaxPalette;
    if (few) sizes.codes.codes[sizes.codes.count++] = code;
  });
  if (few && sizes.codes.count > 1) {
    sizes.palette = 2 + places.count() * index_bits(sizes.codes.count) / 8;
    for (std::size_t i = 0; i < sizes.codes.count; ++i) sizes.palette += code_bytes(sizes.codes.codes[i]);
  }
  return sizes;
}

void write_palette(const BlockValues& values, PlaceRange places, const Palette& palette, PlainWriter& out) {
  out.put(kPaletteByte);
  out.put(palette.count);
  for (std::size_t i = 0; i < palette.count; ++i) out.put_code(palette.codes[i]);
  const std::size_t bits = index_bits(palette.count);
  for (std::size_t i = places.begin; i < places.end; i += 8 / bits) {
    std::size_t byte = 0;
    for (std::size_t k = 0; k < 8 / bits; ++k) byte |= palette.find(values[i + k]) << (k * bits);
    out.put(byte);
  }
}

UnpackError take_code(mapper::ByteReader& in, Rgbo& code) {
  std::uint8_t byte = 0;
  std::array<std::uint8_t, 3> rgb{};
  if (!in.take(byte)) return UnpackError::truncated;
  const std::uint8_t level = byte & mapper::kLevelMask;
  if (level > mapper::kMaxLevel) return UnpackError::bad_level;
  code = level;
  if (byte == level) return UnpackError::none;
  if (byte != (level | mapper::kHasColourBit) || level <= mapper::kUnknownLevel) return UnpackError::bad_colour;
  if (!in.take(rgb)) return UnpackError::truncated;
  code = mapper::make_rgbo(rgb[0], rgb[1], rgb[2], byte);
  return UnpackError::none;
}

UnpackError take_raw(mapper::ByteReader& in, PlaceRange places, BlockValues& out) {
  for (std::size_t i = places.begin; i < places.end; ++i) {
    if (const UnpackError error = take_code(in, out[i]); error != UnpackError::none) return error;
  }
  return UnpackError::none;
}

UnpackError take_palette(mapper::ByteReader& in, PlaceRange places, BlockValues& out) {
  std::uint8_t count = 0;
  if (!in.take(count)) return UnpackError::truncated;
  if (count < 2 || count > kMaxPalette) return UnpackError::bad_palette;
  std::array<Rgbo, kMaxPalette> codes{};
  for (std::size_t i = 0; i < count; ++i) {
    if (const UnpackError error = take_code(in, codes[i]); error != UnpackError::none) return error;
  }
  const std::size_t bits = index_bits(count);
  for (std::size_t i = places.begin; i < places.end; i += 8 / bits) {
    std::uint8_t byte = 0;
    if (!in.take(byte)) return UnpackError::truncated;
    for (std::size_t k = 0; k < 8 / bits; ++k) {
      const std::size_t index = byte >> (k * bits) & ((1U << bits) - 1);
      if (index >= count) return UnpackError::bad_palette;
      out[i + k] = codes[index];
    }
  }
  return UnpackError::none;
}

UnpackError take_runs(mapper::ByteReader& in, PlaceRange places, BlockValues& out) {
  for (std::size_t i = places.begin; i < places.end;) {
    std::uint64_t less_one = 0;
    Rgbo code = 0;
    if (!in.take_varint(less_one)) return in.left() < 9 ? UnpackError::truncated : UnpackError::bad_run;
    if (less_one >= places.end - i) return UnpackError::bad_run;
    if (const UnpackError error = take_code(in, code); error != UnpackError::none) return error;
    std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(i), less_one + 1, code);
    i += less_one + 1;
  }
  return UnpackError::none;
}

}  // namespace

const char* to_string(UnpackError error) {
  constexpr std::array kNames{"none",       "empty",       "truncated", "trailing bytes", "bad level",
                              "bad colour", "bad palette", "bad run",   "wrong end"};
  const auto at = static_cast<std::size_t>(error);
  return at < kNames.size() ? kNames[at] : "unknown";
}

Rgbo tellable(Rgbo code) {
  const std::uint8_t level = std::min(mapper::level_of(code), mapper::kMaxLevel);
  if (level <= mapper::kUnknownLevel || (code & mapper::kHasColourBit) == 0) return level;
  return (code & 0xFFFFFF00U) | mapper::kHasColourBit | level;
}

std::size_t pack_plain(const BlockValues& values, PlaceRange places, std::size_t shorter_than,
                       std::span<std::uint8_t> out) {
  const PlainSizes sizes = measure_plain(values, places);
  PlainWriter writer(out);
  if (sizes.codes.count == 1 && code_bytes(values[places.begin]) == 1) {
    if (shorter_than > 1) writer.put(values[places.begin]);
    return writer.size();
  }
  const std::size_t best = std::min({sizes.raw, sizes.runs, sizes.palette == 0 ? sizes.raw : sizes.palette});
  if (best >= shorter_than) return 0;
  if (best == sizes.palette) {
    write_palette(values, places, sizes.codes, writer);
  } else if (best == sizes.runs) {
    writer.put(kRunsByte);
    for_each_run(values, places, [&](Rgbo code, std::size_t run) {
      if (length_bytes(run) == 2) writer.put(((run - 1) & 0x7FU) | 0x80U);
      writer.put(length_bytes(run) == 2 ? (run - 1) >> 7 : run - 1);
      writer.put_code(code);
    });
  } else {
    writer.put(kRawByte);
    for (std::size_t i = places.begin; i < places.end; ++i) writer.put_code(values[i]);
  }
  return writer.size();
}

UnpackError unpack_plain(ByteSpan bytes, PlaceRange places, BlockValues& out) {
  mapper::ByteReader in(bytes);
  std::uint8_t first = 0;
  if (!in.take(first)) return UnpackError::empty;
  UnpackError error = UnpackError::none;
  if (first <= mapper::kMaxLevel) {
    for (std::size_t i = places.begin; i < places.end; ++i) out[i] = first;
  } else {
    error = first == kRawByte       ? take_raw(in, places, out)
            : first == kPaletteByte ? take_palette(in, places, out)
                                    : take_runs(in, places, out);
  }
  return error == UnpackError::none && in.left() != 0 ? UnpackError::trailing_bytes : error;
}

}  // namespace g3d::net
