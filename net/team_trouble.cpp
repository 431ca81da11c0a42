// SPDX-License-Identifier: Apache-2.0
#include "net/team_trouble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "hal/replay/decimal.hpp"

namespace g3d::net {
namespace {

constexpr double kLatestTrouble_s = 1e6;

std::optional<hal::TimeNs> trouble_time(std::string_view text) {
  const auto seconds = hal::parse_double(text);
  if (!seconds || !(*seconds >= 0.0 && *seconds <= kLatestTrouble_s)) return std::nullopt;
  return static_cast<hal::TimeNs>(*seconds * 1e9);
}

/// From 0.
std::optional<std::uint32_t> robot_number(std::string_view text, std::uint32_t robots) {
  std::uint32_t number = 0;
  if (text.empty() || text.size() > 3) return std::nullopt;
  for (const char digit : text) {
    if (digit < '0' || digit > '9') return std::nullopt;
    number = 10 * number + static_cast<std::uint32_t>(digit - '0');
  }
  if (number < 1 || number > robots) return std::nullopt;
  return number - 1;
}

/// What is before the first `mark`; `text` goes on after it.
std::string_view take_until(std::string_view& text, char mark) {
  const std::size_t at = std::min(text.find(mark), text.size());
  const std::string_view taken = text.substr(0, at);
  text.remove_prefix(std::min(at + 1, text.size()));
  return taken;
}

}  // namespace

bool is_cut(std::span<const RadioCut> cuts, std::uint32_t a, std::uint32_t b, hal::TimeNs now_ns) {
  return std::any_of(cuts.begin(), cuts.end(), [&](const RadioCut& cut) {
    return now_ns >= cut.from_ns && now_ns < cut.to_ns && cut.group[a] != cut.group[b];
  });
}

hal::Result<RadioCut> parse_cut(std::string_view text, std::uint32_t robots) {
  const hal::Error wrong{hal::Reason::bad_usage,
                         fmt::format("'{}' is no cut of the radio: FROM-TO:GROUP|GROUP in seconds, with the numbers of "
                                     "robots (1 to {}, each once) in a group, such as 60-120:1|2",
                                     text.substr(0, 80), robots)};
  RadioCut cut;
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || robots > kMostTeam) return wrong;
  std::string_view times = text.substr(0, colon);
  const std::size_t dash = times.find('-');
  if (dash == std::string_view::npos) return wrong;
  const auto from_ns = trouble_time(times.substr(0, dash)), to_ns = trouble_time(times.substr(dash + 1));
  if (!from_ns || !to_ns || *to_ns <= *from_ns) return wrong;
  cut.from_ns = *from_ns;
  cut.to_ns = *to_ns;
  std::string_view groups = text.substr(colon + 1);
  if (groups.empty() || groups.back() == '|' || groups.back() == ',') return wrong;
  for (std::uint8_t number = 1; !groups.empty(); ++number) {
    std::string_view group = take_until(groups, '|');
    if (group.empty() || group.back() == ',') return wrong;
    while (!group.empty()) {
      const auto robot = robot_number(take_until(group, ','), robots);
      if (!robot || cut.group[*robot] != 0) return wrong;
      cut.group[*robot] = number;
    }
  }
  return cut;
}

hal::Result<RobotDeath> parse_death(std::string_view text, std::uint32_t robots) {
  std::string_view rest = text;
  const auto robot = robot_number(take_until(rest, '@'), robots);
  const auto at_ns = trouble_time(rest);
  if (!robot || !at_ns) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("'{}' kills no robot: ROBOT@SECONDS with a robot from 1 to {}, such as 2@60",
                                  text.substr(0, 80), robots)};
  }
  return RobotDeath{*robot, *at_ns};
}

hal::Result<TeamTrouble> parse_trouble(std::span<const std::string> cuts, std::span<const std::string> deaths,
                                       std::uint32_t robots) {
  TeamTrouble trouble;
  for (const std::string& text : cuts) {
    const auto cut = parse_cut(text, robots);
    if (!cut) return hal::Error{cut.error().reason, "--partition " + cut.error().text};
    trouble.cuts.push_back(cut.value());
  }
  for (const std::string& text : deaths) {
    const auto death = parse_death(text, robots);
    if (!death) return hal::Error{death.error().reason, "--kill " + death.error().text};
    trouble.deaths.push_back(death.value());
  }
  return trouble;
}

}  // namespace g3d::net
