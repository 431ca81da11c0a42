// SPDX-License-Identifier: Apache-2.0
// Numbers and lines of text logs. Stamps are kept to the nanosecond: a double holds today's seconds to 0.2 us only, and
// what is looked up must be what was written.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/messages.hpp"

namespace g3d::hal {

/// Decimal seconds ("1305031230.965035", "-0.5", "1.3e9") as nanoseconds, rounded half away from zero at the tenth
/// decimal. Nothing if it is not a number, or beyond +-kMaxStamp_s.
[[nodiscard]] std::optional<TimeNs> parse_stamp_ns(std::string_view text);
/// Years 1843 to 2096; the difference of two stamps still fits 64 bits.
inline constexpr TimeNs kMaxStamp_s = 4'000'000'000;
/// "1305031230.965035000"; parse_stamp_ns gives the same stamp back.
[[nodiscard]] std::string format_stamp(TimeNs stamp_ns);
/// The same into `out`, without allocating or a zero at the end; returns where it ended, kMaxStampChars on at most.
inline constexpr std::size_t kMaxStampChars = 24;
char* format_stamp_to(char* out, TimeNs stamp_ns);

/// The whole of `text` as a double; "nan" and "inf" are numbers too. Nothing if it is none or overflows.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);
[[nodiscard]] std::optional<int> parse_int(std::string_view text);

/// Takes the first word off `rest`, and the white space around it; empty at the end.
[[nodiscard]] std::string_view take_word(std::string_view& rest);

/// Walks over the lines that say something: not empty, not beginning with `#`.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : rest_(text) {}
  /// The next such line without white space at its ends; nothing at the end of the text.
  [[nodiscard]] std::optional<std::string_view> next();
  /// Of the line that next() returned, from 1.
  [[nodiscard]] int line_number() const { return line_number_; }

 private:
  std::string_view rest_;
  int line_number_ = 0;
};

}  // namespace g3d::hal
