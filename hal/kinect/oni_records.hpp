// SPDX-License-Identifier: Apache-2.0
// The records of an .oni file, one at a time and within the file's bounds; what is in them is for oni_check.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "hal/result.hpp"

namespace g3d::hal::kinect {

using Bytes = std::span<const std::uint8_t>;

/// Little-endian, as the file and both our machines are. Within `bytes`.
template <typename T>
[[nodiscard]] T read_at(Bytes bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Takes fields off their front; `ok` turns false, for good, where they end too early.
struct OniFields {
  Bytes rest;
  bool ok = true;

  Bytes take(std::size_t bytes);
  template <typename T>
  T number() {
    const Bytes taken = take(sizeof(T));
    return ok ? read_at<T>(taken, 0) : T{};
  }
  /// At most `most_bytes`, of which the last is a zero, and none before.
  std::string_view text(std::size_t most_bytes);
};

enum OniRecordType : std::uint32_t {
  kIntProperty = 0x03,
  kRealProperty = 0x04,
  kStringProperty = 0x05,
  kGeneralProperty = 0x06,
  kNodeRemoved = 0x07,
  kDataBegin = 0x08,
  kStateReady = 0x09,
  kNewData = 0x0A,
  kEnd = 0x0B,
  kNodeAdded1005 = 0x0C,  ///< of format 1.0.0.5
  kNodeAdded = 0x0D,
  kSeekTable = 0x0E,
};

struct OniRecord {
  std::size_t at = 0;
  std::uint32_t type = 0;
  std::uint32_t node = 0;
  Bytes fields;  ///< behind the head
  Bytes payload;
};

struct OniHeader {
  bool is_wide = true;  ///< places in the file have 64 bits
  std::uint64_t last_stamp_us = 0;
  std::uint32_t highest_node = 0;
};

/// What the player has room for.
inline constexpr std::size_t kPlayerBuffer_bytes = 1600 * 1200 * 3;

class OniRecords {
 public:
  static constexpr std::size_t kFileHeader_bytes = 24;

  /// Both must outlive this.
  OniRecords(Bytes file, std::string_view name) : file_(file), name_(name) {}
  /// First. Errors: truncated, malformed, unsupported.
  [[nodiscard]] Result<void> read_header();
  [[nodiscard]] const OniHeader& header() const { return header_; }
  /// The record at that place. Errors: truncated, malformed, too_large.
  [[nodiscard]] Result<OniRecord> read(std::size_t at) const;
  /// Where the next one begins.
  [[nodiscard]] std::size_t end_of(const OniRecord& record) const {
    return record.at + head_bytes() + record.fields.size() + record.payload.size();
  }
  [[nodiscard]] Error error(std::size_t at, Reason reason, std::string_view what) const;
  [[nodiscard]] std::string_view name() const { return name_; }

 private:
  [[nodiscard]] Error cut(std::size_t at) const;
  [[nodiscard]] std::size_t head_bytes() const { return header_.is_wide ? 28 : 24; }

  Bytes file_;
  std::string_view name_;
  OniHeader header_;
};

}  // namespace g3d::hal::kinect
