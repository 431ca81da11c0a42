// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/text_fields.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace g3d::hal {

std::optional<double> parse_number(std::string_view word) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (status != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

Error TextLine::error(Reason reason, std::string_view what) const {
  return Error{reason, fmt::format("{}:{}: {}", file_, number_, what)};
}

Result<double> TextLine::number_in(std::string_view word, std::string_view name, double low, double high) const {
  const auto value = parse_number(word);
  if (!value) {
    return error(Reason::malformed, fmt::format("{} is '{}', which is not a number", name, word.substr(0, 40)));
  }
  if (*value < low || *value > high) {
    return error(Reason::out_of_range, fmt::format("{} is {}, allowed are {} to {}", name, *value, low, high));
  }
  return *value;
}

Result<std::vector<TextLine>> split_lines(std::string_view text, std::string_view file) {
  if (text.size() > kMaxTextBytes) {
    return Error{Reason::too_large, fmt::format("{}: {} bytes; at most {} are read", file, text.size(), kMaxTextBytes)};
  }
  std::vector<TextLine> lines;
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    std::vector<std::string_view> words;
    while (!line.empty()) {
      if (line.front() == ' ' || line.front() == '\t') {
        line.remove_prefix(1);
        continue;
      }
      const std::string_view word = line.substr(0, line.find_first_of(" \t"));
      if (word.front() == '#') break;
      for (const char c : word) {
        if (static_cast<unsigned char>(c) < 0x20) {
          return Error{Reason::malformed,
                       fmt::format("{}:{}: control character {}; this is not a text file", file, number, int{c})};
        }
      }
      words.push_back(word);
      line.remove_prefix(word.size());
    }
    if (!words.empty()) lines.emplace_back(file, number, std::move(words));
  }
  return lines;
}

}  // namespace g3d::hal
