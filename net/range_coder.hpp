// SPDX-License-Identifier: Apache-2.0
// Bits of known probability <-> as few bytes as they are worth: the arithmetic half of a block on the wire.
//
// An interval [low, high] of 64 bits is cut in proportion to the probability (16 bits) of each bit; bytes leave as soon
// as both ends agree on them. No carry can happen, so nothing that left ever changes. A message ends with the shortest
// number inside the interval; the decoder reads zeros behind the end, so that zeros at the end are not sent at all.
// What precedes the first bit may be reserved: a coder opened with `first_byte` never writes a smaller first byte,
// which leaves those to other codings at the cost of a fraction of a bit.
//
// Both coders have the same code(), so that a model is written once and works in both directions. Integers alone: the
// same bytes on every machine. Nothing is allocated. Hostile bytes decode to some bits, and at_end() tells whether a
// message with just these bytes could have come from the encoder. One thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "mapper/files/bytes.hpp"
#include "net/bit_model.hpp"

namespace g3d::net {

using mapper::ByteSpan;

/// Where to cut: the part [low, cut] belongs to a set bit. With low < high and 0 < probability < 65536 neither part is
/// empty. Ends that straddle a byte for long make the parts coarse, never wrong.
[[nodiscard]] constexpr std::uint64_t cut_at(std::uint64_t low, std::uint64_t high, std::uint32_t probability) {
  return low + ((high - low) >> kProbabilityBits) * probability +
         ((((high - low) & kProbabilityMask) * probability) >> kProbabilityBits);
}

class RangeEncoder {
 public:
  /// Bytes go to `out`. When it is full, the rest is dropped and finish() gives nothing.
  void open(std::span<std::uint8_t> out, std::uint8_t first_byte);
  bool code(BitModel& model, bool bit) {
    put(model.probability, bit);
    model.learn(bit);
    return bit;
  }
  bool code(Mixed&& mixed, bool bit) {
    put(mixed.probability(), bit);
    mixed.learn(bit);
    return bit;
  }
  /// `count` bits of no known probability, the highest first.
  std::uint32_t code_plain(std::uint32_t bits, int count) {
    for (int i = count - 1; i >= 0; --i) put(kEven, (bits >> i & 1U) != 0);
    return bits;
  }
  /// How many bytes of `out` the message takes; 0 if it did not fit.
  [[nodiscard]] std::size_t finish();

 private:
  void put(std::uint32_t probability, bool bit) {
    const std::uint64_t cut = cut_at(low_, high_, probability);
    high_ = bit ? cut : high_;
    low_ = bit ? low_ : cut + 1;
    while (((low_ ^ high_) >> 56) == 0) shift();
  }
  void shift();

  std::span<std::uint8_t> out_;
  std::size_t size_ = 0;
  std::uint64_t low_ = 0;
  std::uint64_t high_ = 0;
  bool overrun_ = false;
};

class RangeDecoder {
 public:
  /// `bytes` must outlive the decoder's use. Its first byte is not below `first_byte`: the caller looked.
  void open(ByteSpan bytes, std::uint8_t first_byte);
  bool code(BitModel& model, bool /*unused*/) {
    const bool bit = take(model.probability);
    model.learn(bit);
    return bit;
  }
  bool code(Mixed&& mixed, bool /*unused*/) {
    const bool bit = take(mixed.probability());
    mixed.learn(bit);
    return bit;
  }
  std::uint32_t code_plain(std::uint32_t /*unused*/, int count) {
    std::uint32_t bits = 0;
    for (int i = 0; i < count; ++i) bits = bits << 1 | static_cast<std::uint32_t>(take(kEven));
    return bits;
  }
  /// Whether the encoder would have ended a message with these bits just there, and with just these bytes.
  [[nodiscard]] bool at_end() const;

 private:
  bool take(std::uint32_t probability) {
    const std::uint64_t cut = cut_at(low_, high_, probability);
    const bool bit = value_ <= cut;
    high_ = bit ? cut : high_;
    low_ = bit ? low_ : cut + 1;
    while (((low_ ^ high_) >> 56) == 0) shift();
    return bit;
  }
  void shift();

  ByteSpan bytes_;
  std::size_t next_ = 0;     ///< of the bytes to be read, also behind the end
  std::size_t shifted_ = 0;  ///< bytes that the interval has settled
  std::uint64_t low_ = 0;
  std::uint64_t high_ = 0;
  std::uint64_t value_ = 0;
};

/// The number in [low, high] that needs the fewest bytes before its zeros, and of these the lowest: how many bytes.
[[nodiscard]] int bytes_of_shortest(std::uint64_t low, std::uint64_t high, std::uint64_t& number);

}  // namespace g3d::net
