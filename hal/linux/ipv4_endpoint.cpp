// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/ipv4_endpoint.hpp"

#include <fmt/format.h>

namespace g3d::hal {
namespace {

/// A decimal number up to `most`, without leading zeros, and what follows it.
std::optional<std::uint32_t> take_decimal(std::string_view& text, std::uint32_t most) {
  std::uint32_t number = 0;
  std::size_t digits = 0;
  while (digits < text.size() && text[digits] >= '0' && text[digits] <= '9') {
    number = number * 10 + static_cast<std::uint32_t>(text[digits] - '0');
    if (number > most) return std::nullopt;
    ++digits;
  }
  if (digits == 0 || (digits > 1 && text[0] == '0')) return std::nullopt;
  text.remove_prefix(digits);
  return number;
}

bool take_mark(std::string_view& text, char wanted) {
  if (text.empty() || text[0] != wanted) return false;
  text.remove_prefix(1);
  return true;
}

std::optional<std::uint32_t> take_ipv4(std::string_view& text) {
  std::uint32_t ipv4 = 0;
  for (int part = 0; part < 4; ++part) {
    if (part > 0 && !take_mark(text, '.')) return std::nullopt;
    const auto number = take_decimal(text, 255);
    if (!number) return std::nullopt;
    ipv4 = ipv4 << 8 | *number;
  }
  return ipv4;
}

}  // namespace

std::optional<std::uint32_t> parse_ipv4(std::string_view text) {
  const auto ipv4 = take_ipv4(text);
  return text.empty() ? ipv4 : std::nullopt;
}

std::optional<Ipv4Endpoint> parse_ipv4_endpoint(std::string_view text) {
  const auto ipv4 = take_ipv4(text);
  if (!ipv4 || !take_mark(text, ':')) return std::nullopt;
  const auto port = take_decimal(text, 65535);
  if (!port || *port == 0 || !text.empty()) return std::nullopt;
  return Ipv4Endpoint{*ipv4, static_cast<std::uint16_t>(*port)};
}

std::string to_string(const Ipv4Endpoint& endpoint) {
  return fmt::format("{}.{}.{}.{}:{}", endpoint.ipv4 >> 24, endpoint.ipv4 >> 16 & 255, endpoint.ipv4 >> 8 & 255,
                     endpoint.ipv4 & 255, endpoint.port);
}

}  // namespace g3d::hal
