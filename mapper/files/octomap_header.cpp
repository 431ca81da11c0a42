// SPDX-License-Identifier: Apache-2.0
#include "mapper/files/octomap_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

namespace g3d::mapper {
namespace {

using hal::Error;
using hal::Reason;

constexpr std::string_view kFullLine = "# Octomap OcTree file";
constexpr std::string_view kBinaryLine = "# Octomap OcTree binary file";
constexpr std::size_t kMaxLines = 1000;
constexpr std::size_t kMaxLineBytes = 4096;

/// Takes one line off the front; none if no line end comes within kMaxLineBytes.
std::optional<std::string_view> take_line(std::string_view& text) {
  const std::size_t end = text.substr(0, kMaxLineBytes).find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string_view value_after(std::string_view line, std::string_view word) {
  line.remove_prefix(std::min(line.size(), word.size()));
  while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  while (!line.empty() && line.back() == ' ') line.remove_suffix(1);
  return line;
}

template <typename T>
bool parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

bool has_word(std::string_view line, std::string_view word) {
  return line.size() > word.size() && line.substr(0, word.size()) == word && line[word.size()] == ' ';
}

}  // namespace

hal::Result<OctomapHeader> decode_octomap_header(ByteSpan bytes, const std::string& name) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  OctomapHeader header;
  const auto first = take_line(text);
  if (!first || (*first != kFullLine && *first != kBinaryLine)) {
    return Error{
        Reason::malformed,
        fmt::format("{}:1: not an OctoMap file of version 1.x; give a .ot or .bt file that octomap wrote", name)};
  }
  header.is_binary = *first == kBinaryLine;
  bool has_type = false;
  bool has_size = false;
  bool has_resolution = false;
  for (std::size_t number = 2; number < kMaxLines; ++number) {
    const auto line = take_line(text);
    if (!line)
      return Error{Reason::truncated,
                   fmt::format("{}:{}: the header ends before its `data` line; take another copy", name, number)};
    const auto fail = [&](Reason reason, std::string_view what, std::string_view remedy) {
      return Error{reason, fmt::format("{}:{}: {}; {}", name, number, what, remedy)};
    };
    if (line->empty() || line->front() == '#') continue;
    if (*line == "data") {
      if (!has_type || !has_size || !has_resolution)
        return fail(Reason::malformed, "`id`, `size` or `res` is missing", "take another copy");
      header.data_offset = bytes.size() - text.size();
      return header;
    }
    if (has_word(*line, "id")) {
      const std::string_view type = value_after(*line, "id");
      if (type != "OcTree" && type != "ColorOcTree") {
        return fail(Reason::unsupported, "neither OcTree nor ColorOcTree", "convert it with octomap's own tools");
      }
      header.is_coloured = type == "ColorOcTree";
      has_type = true;
    } else if (has_word(*line, "size")) {
      if (!parse(value_after(*line, "size"), header.nodes))
        return fail(Reason::malformed, "`size` is not a count", "take another copy");
      has_size = true;
    } else if (has_word(*line, "res")) {
      if (!parse(value_after(*line, "res"), header.resolution_m))
        return fail(Reason::malformed, "`res` is not a number", "take another copy");
      if (!(header.resolution_m >= 0.0005 && header.resolution_m <= 100.0)) {
        return fail(Reason::out_of_range, "`res` is outside of 0.0005..100 m", "check the file's maker");
      }
      has_resolution = true;
    } else {
      return fail(Reason::malformed, "an unknown word", "expected `id`, `size`, `res` or `data`");
    }
  }
  return Error{Reason::too_large, fmt::format("{}: the header has over {} lines; take another copy", name, kMaxLines)};
}

}  // namespace g3d::mapper
