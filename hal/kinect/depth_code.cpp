// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/depth_code.hpp"

namespace g3d::hal::kinect {
namespace {

class CodeReader {
 public:
  explicit CodeReader(std::span<const std::uint8_t> code) : rest_(code) {}
  [[nodiscard]] bool is_at_end() const { return rest_.empty(); }
  [[nodiscard]] std::size_t left() const { return rest_.size(); }
  bool read_u8(std::uint8_t& value) {
    if (rest_.empty()) return false;
    value = rest_.front();
    rest_ = rest_.subspan(1);
    return true;
  }
  bool read_u16(std::uint16_t& value) {
    if (rest_.size() < 2) return false;
    value = static_cast<std::uint16_t>(rest_[0] | rest_[1] << 8);
    rest_ = rest_.subspan(2);
    return true;
  }
  bool skip(std::size_t bytes) {
    if (rest_.size() < bytes) return false;
    rest_ = rest_.subspan(bytes);
    return true;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

}  // namespace

// A byte below 0xE0 holds two differences, -6..+7, of which the second may say "none" (0xD) or "a larger one follows"
// (0xF); 0xE0..0xFE repeat the last value twice that often; after 0xFF comes a larger one: a byte from 0x80 on is a
// difference of -64..+63, else it is the high byte of the value itself.
bool is_whole_depth_code(std::span<const std::uint8_t> code, bool has_table, std::size_t pixels) {
  CodeReader reader(code);
  std::uint16_t entries = 0;
  if (has_table && (!reader.read_u16(entries) || !reader.skip(std::size_t{2} * entries))) return false;
  std::uint16_t last = 0;
  std::size_t written = 0;
  const auto write = [&](std::size_t count) {
    written += count;
    return written <= pixels && (!has_table || last < entries);
  };
  const auto read_larger = [&] {
    std::uint8_t first = 0, second = 0;
    if (!reader.read_u8(first)) return false;
    if ((first & 0x80) != 0) {
      last = static_cast<std::uint16_t>(last - (static_cast<int>(first) - 192));
    } else {
      if (!reader.read_u8(second)) return false;
      last = static_cast<std::uint16_t>(first << 8 | second);
    }
    return write(1);
  };
  // The first value stands there as it is.
  if (pixels == 0 || !reader.read_u16(last) || !write(1)) return false;
  while (!reader.is_at_end()) {
    std::uint8_t byte = 0;
    if (!reader.read_u8(byte)) return false;
    if (byte == 0xFF) {
      if (!read_larger()) return false;
    } else if (byte >= 0xE0) {
      if (!write(std::size_t{2} * (byte - 0xE0U))) return false;
    } else {
      last = static_cast<std::uint16_t>(last - ((byte >> 4) - 6));
      if (!write(1)) return false;
      const int second = byte & 0x0F;
      if (second == 0x0F) {
        if (!read_larger()) return false;
      } else if (second != 0x0D) {
        last = static_cast<std::uint16_t>(last - (second - 6));
        if (!write(1)) return false;
      }
    }
  }
  return written == pixels;
}

}  // namespace g3d::hal::kinect
