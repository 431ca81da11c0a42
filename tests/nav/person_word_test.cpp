// SPDX-License-Identifier: Apache-2.0
#include "nav/person_word.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d::nav;

TEST_CASE("five words are words, with a line feed or without") {
  for (int i = 0; i < static_cast<int>(PersonWord::count_); ++i) {
    const auto word = static_cast<PersonWord>(i);
    CHECK(parse_word(to_string(word)) == word);
    CHECK(parse_word(std::string(to_string(word)) + "\n") == word);
    CHECK(event_of(word).has_value() == (word != PersonWord::status));
  }
  CHECK(event_of(PersonWord::home) == MissionEvent::come_home);
}

TEST_CASE("anything else is none") {
  using namespace std::string_literals;
  for (const std::string& text : {""s, "\n"s, "Pause"s, "pause "s, " pause"s, "pause\n\n"s, "pauseresume"s, "pause\0"s,
                                  "pause\r\n"s, "unknown"s, "\xff\xfe"s, std::string(100'000, 'p')}) {
    INFO(text.substr(0, 20));
    CHECK_FALSE(parse_word(text).has_value());
  }
}

TEST_CASE("a script says a word at its time") {
  const TimedWord word = parse_timed_word("20.5:pause").value();
  CHECK(word.at_ns == 20'500'000'000);
  CHECK(word.word == PersonWord::pause);
  for (const char* text : {"", ":", "20", "20:", ":pause", "-1:pause", "x:pause", "nan:pause", "20:status", "20:sleep",
                           "20:pause:", "1e9:stop"}) {
    INFO(text);
    REQUIRE_FALSE(parse_timed_word(text).ok());
    CHECK(parse_timed_word(text).error().text.find("20:pause") != std::string::npos);
  }
}
