// SPDX-License-Identifier: Apache-2.0
// `kobuki.bin`: the bytes of a base's line as they were received. Records of i64 t_ns, u16 n, n bytes, little-endian,
// in the order of time. A process that was killed leaves half a record at the end, which is no error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// More than a day of a base's packets.
inline constexpr std::size_t kMaxKobukiLog_bytes = std::size_t{1} << 29;

struct LineRecord {
  TimeNs t_ns = 0;
  std::span<const std::uint8_t> bytes;  ///< never empty
};

class KobukiLog {
 public:
  /// Checks the whole file. Errors: what read_file says; malformed (a record without bytes, or earlier than the one
  /// before), out_of_range (a time beyond what a log can hold). They name `name` and the byte.
  static Result<KobukiLog> open(const std::string& path);
  static Result<KobukiLog> parse(std::vector<std::uint8_t> file, std::string_view name);

  [[nodiscard]] std::size_t record_count() const { return record_count_; }
  /// Of half a record at the end, dropped.
  [[nodiscard]] std::size_t torn_bytes() const { return torn_bytes_; }

  /// Walks over the records. The log must outlive it.
  class Cursor {
   public:
    explicit Cursor(const KobukiLog& log) : rest_(log.file_) {}
    /// The next record, without taking it; nothing at the end.
    [[nodiscard]] std::optional<LineRecord> peek() const;
    void advance();

   private:
    std::span<const std::uint8_t> rest_;
  };
  [[nodiscard]] Cursor records() const { return Cursor(*this); }

 private:
  std::vector<std::uint8_t> file_;  // whole records only
  std::size_t record_count_ = 0;
  std::size_t torn_bytes_ = 0;
};

/// Adds a record to a file in memory; more than 65535 bytes become several.
void append_record(std::vector<std::uint8_t>& file, TimeNs t_ns, std::span<const std::uint8_t> bytes);

}  // namespace g3d::hal
