// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/decimal.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

namespace g3d::hal {
namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr int kNsDigits = 9;
// Beyond it the stamp is zero or too large, whatever its digits are.
constexpr int kMaxExponent = 40;

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view without_plus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

template <typename Number>
std::optional<Number> parse_any(std::string_view text) {
  text = without_plus(text);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Sign, digits with at most one point among them, exponent.
struct DecimalParts {
  bool negative = false;
  std::string_view digits;  // with the point, if there is one
  std::size_t whole = 0;    // digits before the point
  int exponent = 0;
};

std::optional<DecimalParts> split_decimal(std::string_view text) {
  DecimalParts parts;
  if (!text.empty() && (text[0] == '-' || text[0] == '+')) {
    parts.negative = text[0] == '-';
    text.remove_prefix(1);
  }
  std::size_t end = 0;
  std::size_t digit_count = 0;
  bool point = false;
  for (; end < text.size() && (is_digit(text[end]) || (text[end] == '.' && !point)); ++end) {
    if (text[end] == '.') {
      point = true;
      parts.whole = end;
    } else {
      ++digit_count;
    }
  }
  if (digit_count == 0) return std::nullopt;
  if (!point) parts.whole = end;
  parts.digits = text.substr(0, end);
  if (end < text.size()) {
    if (text[end] != 'e' && text[end] != 'E') return std::nullopt;
    const auto exponent = parse_any<int>(text.substr(end + 1));
    if (!exponent || *exponent > kMaxExponent || *exponent < -kMaxExponent) return std::nullopt;
    parts.exponent = *exponent;
  }
  return parts;
}

}  // namespace

std::optional<TimeNs> parse_stamp_ns(std::string_view text) {
  const std::optional<DecimalParts> parts = split_decimal(text);
  if (!parts) return std::nullopt;
  // Digit i stands for 10^(last_ns_digit - i) ns; the one after the last decides the rounding.
  const auto last_ns_digit = static_cast<std::ptrdiff_t>(parts->whole) - 1 + parts->exponent + kNsDigits;
  TimeNs value_ns = 0;
  std::ptrdiff_t i = 0;
  for (const char c : parts->digits) {
    if (c == '.') continue;
    if (i <= last_ns_digit) {
      value_ns = value_ns * 10 + (c - '0');
      if (value_ns > kMaxStamp_s * kSecond_ns / 10 && i < last_ns_digit) return std::nullopt;
    } else {
      if (i == last_ns_digit + 1 && c >= '5') ++value_ns;
      break;
    }
    ++i;
  }
  for (; i <= last_ns_digit && value_ns != 0; ++i) {  // "1e9": zeros that are not written
    if (value_ns > kMaxStamp_s * kSecond_ns / 10) return std::nullopt;
    value_ns *= 10;
  }
  if (value_ns > kMaxStamp_s * kSecond_ns) return std::nullopt;
  return parts->negative ? -value_ns : value_ns;
}

char* format_stamp_to(char* out, TimeNs stamp_ns) {
  const bool negative = stamp_ns < 0;
  const auto magnitude_ns = negative ? 0 - static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
  constexpr std::uint64_t kNs = kSecond_ns;
  return fmt::format_to(out, "{}{}.{:09}", negative ? "-" : "", magnitude_ns / kNs, magnitude_ns % kNs);
}

std::string format_stamp(TimeNs stamp_ns) {
  std::array<char, kMaxStampChars> buffer;
  return {buffer.data(), format_stamp_to(buffer.data(), stamp_ns)};
}

std::optional<double> parse_double(std::string_view text) { return parse_any<double>(text); }
std::optional<int> parse_int(std::string_view text) { return parse_any<int>(text); }

std::string_view take_word(std::string_view& rest) {
  rest = trimmed(rest);
  std::size_t end = 0;
  while (end < rest.size() && !is_blank(rest[end])) ++end;
  const std::string_view word = rest.substr(0, end);
  rest = trimmed(rest.substr(end));
  return word;
}

std::optional<std::string_view> LineReader::next() {
  while (!rest_.empty()) {
    const std::size_t end = rest_.find('\n');
    const std::string_view line = trimmed(rest_.substr(0, end));
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    ++line_number_;
    if (!line.empty() && line.front() != '#') return line;
  }
  return std::nullopt;
}

}  // namespace g3d::hal
