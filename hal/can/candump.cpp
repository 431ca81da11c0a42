// SPDX-License-Identifier: Apache-2.0
#include "hal/can/candump.hpp"

#include <algorithm>
#include <charconv>
#include <optional>

namespace g3d::hal::can {
namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr TimeNs kMicrosecond_ns = 1'000;
constexpr std::size_t kMicrosecondDigits = 6;
constexpr std::uint32_t kErrorFlag = 0x20000000;  // as candump prints error frames
constexpr std::string_view kDigits = "0123456789ABCDEF";

char* put_digits(char* out, std::uint64_t value, std::size_t digits, std::uint64_t base) {
  for (std::size_t i = digits; i-- > 0; value /= base) out[i] = kDigits[value % base];
  return out + digits;
}

int hex_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// All of `text` as digits alone; nothing if it is empty or has anything else.
std::optional<std::uint32_t> hex_number(std::string_view text) {
  std::uint32_t value = 0;
  for (const char c : text) {
    if (hex_of(c) < 0) return std::nullopt;
    value = value << 4 | static_cast<std::uint32_t>(hex_of(c));
  }
  return text.empty() ? std::nullopt : std::optional(value);
}

std::optional<TimeNs> decimal_number(std::string_view text) {
  TimeNs value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || text.front() == '-') return std::nullopt;
  return value;
}

/// Takes "(S.UUUUUU) " off `rest`.
std::optional<TimeNs> take_stamp(std::string_view& rest) {
  const std::size_t close = rest.find(") ");
  const std::size_t point = rest.find('.');
  if (rest.empty() || rest.front() != '(' || close == rest.npos || point == rest.npos || point + 1 > close) return {};
  if (close - point - 1 != kMicrosecondDigits || point < 2) return {};
  const auto seconds = decimal_number(rest.substr(1, point - 1));
  const auto microseconds = decimal_number(rest.substr(point + 1, kMicrosecondDigits));
  if (!seconds || !microseconds || *seconds > kMaxCandumpStamp_s) return {};
  rest.remove_prefix(close + 2);
  return *seconds * kSecond_ns + *microseconds * kMicrosecond_ns;
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= kMaxInterfaceName &&
         std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < 0x7F && c != '#' && c != '/'; });
}

BadCandump set_identifier(std::string_view text, CanFrame& frame) {
  const auto id = hex_number(text);
  if (!id || (text.size() != 3 && text.size() != 8)) return BadCandump::identifier;
  frame.is_extended = text.size() == 8;
  frame.id = *id;
  if (frame.is_extended && (*id & kErrorFlag) != 0) {
    frame.is_error = true;
    frame.is_extended = false;
    frame.id = *id & ~kErrorFlag;
  }
  const std::uint32_t most = frame.is_extended || frame.is_error ? kMaxExtendedId : kMaxStandardId;
  return frame.id <= most ? BadCandump::none : BadCandump::identifier;
}

BadCandump set_data(std::string_view text, CanFrame& frame) {
  if (text.starts_with('#')) return BadCandump::flexible;
  if (text.starts_with('R') || text.starts_with('r')) {
    if (frame.is_error) return BadCandump::data;
    frame.is_remote = true;
    text.remove_prefix(1);
    if (text.empty()) return BadCandump::none;
    const int size = hex_of(text.front());
    if (text.size() != 1) return BadCandump::rest;
    if (size < 0 || size > static_cast<int>(kMaxData_bytes)) return BadCandump::data;
    frame.size = static_cast<std::uint8_t>(size);
    return BadCandump::none;
  }
  if (text.size() % 2 != 0 || text.size() > 2 * kMaxData_bytes) return BadCandump::data;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const auto byte = hex_number(text.substr(i, 2));
    if (!byte) return BadCandump::data;
    frame.data[frame.size++] = static_cast<std::uint8_t>(*byte);
  }
  return BadCandump::none;
}

}  // namespace

std::size_t format_candump_to(char* out, const StampedCanFrame& stamped, std::string_view interface) {
  const CanFrame& f = stamped.frame;
  const TimeNs t_ns = std::clamp<TimeNs>(stamped.t_ns, 0, kMaxCandumpStamp_s * kSecond_ns);
  char* at = out;
  *at++ = '(';
  at = std::to_chars(at, at + 20, t_ns / kSecond_ns).ptr;
  *at++ = '.';
  at = put_digits(at, static_cast<std::uint64_t>(t_ns % kSecond_ns / kMicrosecond_ns), kMicrosecondDigits, 10);
  *at++ = ')';
  *at++ = ' ';
  at = std::copy_n(interface.begin(), std::min(interface.size(), kMaxInterfaceName), at);
  *at++ = ' ';
  at = put_digits(at, f.is_error ? f.id | kErrorFlag : f.id, f.is_extended || f.is_error ? 8 : 3, 16);
  *at++ = '#';
  if (f.is_remote) {
    *at++ = 'R';
    if (f.size > 0) *at++ = kDigits[f.size];
  } else {
    for (std::size_t i = 0; i < f.size; ++i) at = put_digits(at, f.data[i], 2, 16);
  }
  *at++ = '\n';
  return static_cast<std::size_t>(at - out);
}

const char* to_string(BadCandump reason) {
  switch (reason) {
    case BadCandump::none:
      return "nothing";
    case BadCandump::stamp:
      return "does not begin with (SECONDS.MICROSECONDS)";
    case BadCandump::interface:
      return "has no name of an interface, of 1 to 15 characters";
    case BadCandump::identifier:
      return "has no identifier of 3 or 8 hexadecimal digits within its limits";
    case BadCandump::data:
      return "has no data of 0 to 8 bytes, two hexadecimal digits each";
    case BadCandump::flexible:
      return "is a frame of CAN FD, which is not handled here";
    case BadCandump::rest:
      return "has something behind the frame";
  }
  return "unknown";
}

CandumpLine parse_candump(std::string_view line) {
  CandumpLine parsed;
  std::string_view rest = line;
  const auto t_ns = take_stamp(rest);
  if (!t_ns) return {BadCandump::stamp, {}, {}};
  parsed.stamped.t_ns = *t_ns;
  const std::size_t space = rest.find(' ');
  parsed.interface = rest.substr(0, space);
  if (space == rest.npos || !is_name(parsed.interface)) return {BadCandump::interface, {}, {}};
  rest.remove_prefix(space + 1);
  const std::size_t mark = rest.find('#');
  if (mark == rest.npos) return {BadCandump::identifier, {}, {}};
  parsed.bad = set_identifier(rest.substr(0, mark), parsed.stamped.frame);
  rest.remove_prefix(mark + 1);
  // Newer versions of candump say behind it which way it went.
  if (parsed.bad == BadCandump::none && rest.find(' ') != rest.npos) {
    const std::string_view way = rest.substr(rest.find(' '));
    if (way != " R" && way != " T") return {BadCandump::rest, {}, {}};
    rest.remove_suffix(way.size());
  }
  if (parsed.bad == BadCandump::none) parsed.bad = set_data(rest, parsed.stamped.frame);
  if (parsed.bad != BadCandump::none) return {parsed.bad, {}, {}};
  return parsed;
}

}  // namespace g3d::hal::can
