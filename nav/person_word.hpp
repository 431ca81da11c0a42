// SPDX-License-Identifier: Apache-2.0
// What a person can say to a robot that runs: five words, and the times at which a script says them.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "hal/messages.hpp"
#include "hal/result.hpp"
#include "nav/mission.hpp"

namespace g3d::nav {

enum class PersonWord : std::uint8_t { pause, resume, stop, home, status, count_ };
[[nodiscard]] const char* to_string(PersonWord word);

/// Any bytes from outside: exactly one of the words, with at most one line feed after it, or nothing.
[[nodiscard]] std::optional<PersonWord> parse_word(std::string_view bytes);
/// What it is to the mission; `status` is nothing to it.
[[nodiscard]] std::optional<MissionEvent> event_of(PersonWord word);

struct TimedWord {
  hal::TimeNs at_ns = 0;  ///< since the start
  PersonWord word = PersonWord::status;
};
/// "SECONDS:WORD", such as 20:pause. Errors: bad_usage.
[[nodiscard]] hal::Result<TimedWord> parse_timed_word(std::string_view text);

}  // namespace g3d::nav
