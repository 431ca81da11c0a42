// SPDX-License-Identifier: Apache-2.0
#include "nav/person_word.hpp"

#include <fmt/format.h>

#include <array>

#include "hal/replay/decimal.hpp"

namespace g3d::nav {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(PersonWord::count_)> kWords{"pause", "resume", "stop",
                                                                                       "home", "status"};
constexpr double kLatest_s = 1e6;

}  // namespace

const char* to_string(PersonWord word) {
  return word < PersonWord::count_ ? kWords[static_cast<std::size_t>(word)] : "unknown";
}

std::optional<PersonWord> parse_word(std::string_view bytes) {
  if (bytes.ends_with('\n')) bytes.remove_suffix(1);
  for (std::size_t i = 0; i < kWords.size(); ++i) {
    if (bytes == kWords[i]) return static_cast<PersonWord>(i);
  }
  return std::nullopt;
}

std::optional<MissionEvent> event_of(PersonWord word) {
  switch (word) {
    case PersonWord::pause:
      return MissionEvent::pause;
    case PersonWord::resume:
      return MissionEvent::resume;
    case PersonWord::stop:
      return MissionEvent::stop;
    case PersonWord::home:
      return MissionEvent::come_home;
    case PersonWord::status:
    case PersonWord::count_:
      break;
  }
  return std::nullopt;
}

hal::Result<TimedWord> parse_timed_word(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto at_s = hal::parse_double(text.substr(0, colon));
  const auto word = parse_word(colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1));
  if (!at_s || !(*at_s >= 0.0 && *at_s <= kLatest_s) || !word || *word == PersonWord::status) {
    return hal::Error{hal::Reason::bad_usage,
                      fmt::format("'{}' is not SECONDS:WORD with pause, resume, stop or home as WORD, such as 20:pause",
                                  text.substr(0, 80))};
  }
  return TimedWord{static_cast<hal::TimeNs>(*at_s * 1e9), *word};
}

}  // namespace g3d::nav
