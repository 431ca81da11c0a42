// SPDX-License-Identifier: Apache-2.0
// Finds frames `AA 55 | LEN | payload | CS` in a stream that may hold anything. The payload is a row of blocks
// `ID | SIZE | data`; a header is given up as soon as its blocks cannot fit, so that a wrong LEN does not hold back the
// good frames behind it, and the search goes on at the byte after the failed header: nothing whole is ever dropped.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/kobuki/rejects.hpp"

namespace g3d::hal::kobuki {

inline constexpr std::uint8_t kFrameHeader0 = 0xAA, kFrameHeader1 = 0x55;
inline constexpr std::size_t kMinPayload_bytes = 3;
/// All blocks that bases were ever seen to send take 154, with the most gyro samples. Less than 0xAA: neither a doubled
/// header nor the header behind a frame that has lost its end can be taken for a length.
inline constexpr std::size_t kMaxPayload_bytes = 160;
inline constexpr std::size_t kMaxFrame_bytes = kMaxPayload_bytes + 4;

/// One block of a payload.
struct Block {
  std::uint8_t id = 0;
  std::span<const std::uint8_t> data;
};
/// Takes the first block off `payload`; false if the rest is none.
[[nodiscard]] bool take_block(std::span<const std::uint8_t>& payload, Block& block);

/// Whether a block of this ID may have this size; unknown IDs may have any.
using SizeRule = bool (*)(std::uint8_t id, std::size_t size_bytes);

/// One thread. Allocates nothing.
class FrameScanner {
 public:
  explicit FrameScanner(SizeRule size_is_right) : size_is_right_(size_is_right) {}
  /// Takes as many of `bytes` as there is room for, at least one if next() has returned nothing; says how many.
  [[nodiscard]] std::size_t append(std::span<const std::uint8_t> bytes);
  /// The payload of the next whole frame; empty if more bytes are needed. Valid until the next append.
  [[nodiscard]] std::span<const std::uint8_t> next(RejectCounts& rejects);
  void clear() { begin_ = end_ = checked_bytes_ = 0; }

 private:
  enum class Verdict { whole, unfinished, wrong };
  [[nodiscard]] bool find_header(RejectCounts& rejects);
  [[nodiscard]] Verdict check_frame(Reject& reason);

  SizeRule size_is_right_;
  std::array<std::uint8_t, 1024> buffer_;
  std::size_t begin_ = 0, end_ = 0;
  std::size_t checked_bytes_ = 0;  // of the payload at begin_, in whole blocks
};

/// Writes header, length and checksum around blocks that the caller adds.
class FrameWriter {
 public:
  /// Precondition: `out` has room for all blocks, at most kMaxFrame_bytes in all.
  explicit FrameWriter(std::span<std::uint8_t> out) : out_(out) {}
  void begin_block(std::uint8_t id, std::uint8_t size_bytes);
  void put_u8(std::uint8_t value) { out_[end_++] = value; }
  void put_u16(std::uint16_t value);
  void put_u32(std::uint32_t value);
  /// The size of the whole frame.
  [[nodiscard]] std::size_t finish();

 private:
  std::span<std::uint8_t> out_;
  std::size_t end_ = 3;
};

[[nodiscard]] inline std::uint16_t get_u16(std::span<const std::uint8_t> data, std::size_t at) {
  return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}
[[nodiscard]] inline std::int16_t get_s16(std::span<const std::uint8_t> data, std::size_t at) {
  return static_cast<std::int16_t>(get_u16(data, at));
}
[[nodiscard]] inline std::uint32_t get_u32(std::span<const std::uint8_t> data, std::size_t at) {
  return get_u16(data, at) | static_cast<std::uint32_t>(get_u16(data, at + 2)) << 16;
}

}  // namespace g3d::hal::kobuki
