// SPDX-License-Identifier: Apache-2.0
// What messages are made of: a writer with memory of its own for one of them, and the parts that several kinds have.
// Numbers are LEB128 varints unless said otherwise. What is taken is checked step by step. One thread; allocates
// nothing.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "mapper/files/bytes.hpp"
#include "net/layer_store.hpp"

namespace g3d::net {

/// Of a message before it is sealed: datagrams have at most 1200 bytes.
inline constexpr std::size_t kMostMessage_bytes = 1160;
/// A longer payload fits no datagram together with what stands around it.
inline constexpr std::size_t kMostPayload_bytes = 1090;
inline constexpr std::size_t kVarint_bytes = 9;
inline constexpr std::size_t kLayerId_bytes = 12;
/// No writer gets there: 2^48 versions last for a thousand years.
inline constexpr Version kMostVersion = Version{1} << 48;

enum class MessageFault : std::uint8_t {
  none,
  unknown_kind,
  truncated,
  left_over,
  bad_range,   ///< versions that no writer reaches, or that do not ascend
  bad_record,  ///< key, lane or length of a record
  too_many,    ///< more layers or ranges than a datagram can hold
};
inline constexpr std::size_t kMessageFaults = 7;

/// What somebody has of a layer.
using HadLanes = std::array<VersionRanges, kLanes>;
/// Where somebody stands in a layer, by its whole name.
struct LayerPosition {
  LayerId id;
  HadLanes had{};
};
/// The same by its short name.
struct WantedLayer {
  LayerAlias layer = 0;
  HadLanes had{};
};
[[nodiscard]] constexpr std::size_t varint_bytes(std::uint64_t value) {
  std::size_t bytes = 1;
  for (; value >= 0x80U; value >>= 7) ++bytes;
  return bytes;
}

class WireWriter {
 public:
  void begin(std::uint8_t kind) {
    size_ = 0;
    put(kind);
  }
  template <typename T>
  void put(T value) {
    std::memcpy(bytes_.data() + size_, &value, sizeof(T));
    size_ += sizeof(T);
  }
  void put_varint(std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7) put(static_cast<std::uint8_t>(value | 0x80U));
    put(static_cast<std::uint8_t>(value));
  }
  void put_layer_id(const LayerId& id) {
    put(id.robot);
    put(id.incarnation);
  }
  /// Of which lanes there are ranges beyond (u8, a bit each), upto of the first lane, of the others the difference
  /// (zigzag) to the lane before; then per lane that has them: number of ranges, and per range gap and length.
  void put_had(const HadLanes& had);
  /// False if there is no room; then nothing was written.
  bool put_position(const LayerPosition& position);
  bool put_wanted(const WantedLayer& wanted);
  /// So many bytes for somebody else to write.
  std::span<std::uint8_t> skip(std::size_t bytes) {
    const std::span<std::uint8_t> place{bytes_.data() + size_, bytes};
    size_ += bytes;
    return place;
  }
  /// Forgets what was written after it had that size.
  void cut(std::size_t size) { size_ = size; }
  /// A byte that was written before.
  [[nodiscard]] std::uint8_t& at(std::size_t place) { return bytes_[place]; }
  /// All that is left of a message.
  [[nodiscard]] std::span<std::uint8_t> rest() { return {bytes_.data() + size_, kMostMessage_bytes - size_}; }
  [[nodiscard]] bool has_room(std::size_t bytes) const { return size_ + bytes <= kMostMessage_bytes; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] mapper::ByteSpan bytes() const { return {bytes_.data(), size_}; }

 private:
  template <typename Write>
  bool put_if_it_fits(Write&& write);

  /// Room to write a position before it is known whether it fits.
  std::array<std::uint8_t, kMostMessage_bytes + 1024> bytes_{};
  std::size_t size_ = 0;
};

[[nodiscard]] inline bool take_layer_id(mapper::ByteReader& in, LayerId& id) {
  return in.take(id.robot) && in.take(id.incarnation);
}
[[nodiscard]] MessageFault take_position(mapper::ByteReader& in, LayerPosition& position);
[[nodiscard]] MessageFault take_wanted(mapper::ByteReader& in, WantedLayer& wanted);

/// Small for small differences either way; differences of keys wrap around.
[[nodiscard]] constexpr std::uint64_t zigzag(std::uint64_t difference) {
  return (difference << 1) ^ (0 - (difference >> 63));
}
[[nodiscard]] constexpr std::uint64_t from_zigzag(std::uint64_t value) { return (value >> 1) ^ (0 - (value & 1)); }

/// The kind of a message, and what stands in front of the rest.
template <typename... Fields>
[[nodiscard]] MessageFault take_head(mapper::ByteReader& in, std::uint8_t kind, Fields&... fields) {
  std::uint8_t found = 0;
  if (!in.take(found)) return MessageFault::truncated;
  if (found != kind) return MessageFault::unknown_kind;
  return (in.take(fields) && ...) ? MessageFault::none : MessageFault::truncated;
}

}  // namespace g3d::net
