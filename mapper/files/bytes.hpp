// SPDX-License-Identifier: Apache-2.0
// Little-endian numbers in byte buffers: append to one, or take from one with every step checked against its end.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace g3d::mapper {

static_assert(std::endian::native == std::endian::little, "files are little-endian; all our targets are, too");

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

template <typename T>
void put(Bytes& out, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t at = out.size();
  out.resize(at + sizeof(T));
  std::memcpy(out.data() + at, &value, sizeof(T));
}

inline void put_bytes(Bytes& out, ByteSpan bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

/// LEB128: seven bits per byte, lowest first.
inline void put_varint(Bytes& out, std::uint64_t value) {
  for (; value >= 0x80U; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80U));
  out.push_back(static_cast<std::uint8_t>(value));
}

/// Takes from the front of a span. A take past the end fails and changes nothing.
class ByteReader {
 public:
  explicit ByteReader(ByteSpan bytes) : bytes_(bytes) {}

  template <typename T>
  [[nodiscard]] bool take(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (left() < sizeof(T)) return false;
    std::memcpy(&value, bytes_.data() + offset_, sizeof(T));
    offset_ += sizeof(T);
    return true;
  }
  [[nodiscard]] bool take_bytes(std::size_t count, ByteSpan& out) {
    if (left() < count) return false;
    out = bytes_.subspan(offset_, count);
    offset_ += count;
    return true;
  }
  /// At most nine bytes (63 bits): no number in our files is longer.
  [[nodiscard]] bool take_varint(std::uint64_t& value) {
    value = 0;
    for (std::size_t i = 0; i < 9 && i < left(); ++i) {
      const std::uint8_t byte = bytes_[offset_ + i];
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << (7 * i);
      if (byte < 0x80U) {
        offset_ += i + 1;
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - offset_; }

 private:
  ByteSpan bytes_;
  std::size_t offset_ = 0;
};

}  // namespace g3d::mapper
