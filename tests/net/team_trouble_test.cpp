// SPDX-License-Identifier: Apache-2.0
#include "net/team_trouble.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace g3d;

TEST_CASE("a cut parts groups for its time alone", "[net][trouble]") {
  const auto cut = net::parse_cut("60-120.5:1,2|4", 4);
  REQUIRE(cut);
  CHECK(cut.value().from_ns == 60'000'000'000);
  CHECK(cut.value().to_ns == 120'500'000'000);
  const std::vector<net::RadioCut> cuts{cut.value()};
  CHECK_FALSE(net::is_cut(cuts, 0, 3, 59'999'999'999));
  CHECK(net::is_cut(cuts, 0, 3, 60'000'000'000));
  CHECK(net::is_cut(cuts, 3, 1, 120'499'999'999));
  CHECK_FALSE(net::is_cut(cuts, 0, 3, 120'500'000'000));
  CHECK_FALSE(net::is_cut(cuts, 0, 1, 70'000'000'000));
  // Who was not named hears nobody that was.
  CHECK(net::is_cut(cuts, 2, 0, 70'000'000'000));
  CHECK(net::is_cut(cuts, 2, 3, 70'000'000'000));
}

TEST_CASE("what is no cut is refused, with what would be one", "[net][trouble]") {
  for (const char* text :
       {"",          "60-120",     "60:1|2",      "120-60:1|2",  "60-60:1|2",   "-60-120:1|2", "60-120:",
        "60-120:1|", "60-120:|1",  "60-120:1,|2", "60-120:0|1",  "60-120:1|3",  "60-120:1|1",  "60-120:one|2",
        "x-120:1|2", "60-1e9:1|2", "60-nan:1|2",  "60-120:1|2,", "60-120:1 |2", "60-120:1||2"}) {
    INFO(text);
    const auto cut = net::parse_cut(text, 2);
    REQUIRE_FALSE(cut);
    CHECK(cut.error().reason == hal::Reason::bad_usage);
    CHECK(cut.error().text.find("60-120:1|2") != std::string::npos);
  }
}

TEST_CASE("who dies is said by number and second", "[net][trouble]") {
  const auto death = net::parse_death("2@60.5", 2);
  REQUIRE(death);
  CHECK(death.value().robot == 1);
  CHECK(death.value().at_ns == 60'500'000'000);
  for (const char* text : {"", "2", "@60", "2@", "0@60", "3@60", "2@-1", "2@x", "2@60@70", "+1@3"}) {
    INFO(text);
    const auto wrong = net::parse_death(text, 2);
    REQUIRE_FALSE(wrong);
    CHECK(wrong.error().reason == hal::Reason::bad_usage);
  }
}

TEST_CASE("all of a team's trouble is read, or what is wrong is said with its option", "[net][trouble]") {
  const std::vector<std::string> cuts{"1-2:1|2", "3-4:2|1"}, deaths{"1@5"}, wrong{"7@5"};
  const auto trouble = net::parse_trouble(cuts, deaths, 2);
  REQUIRE(trouble);
  CHECK(trouble.value().cuts.size() == 2);
  CHECK(trouble.value().deaths.size() == 1);
  CHECK(net::parse_trouble(cuts, wrong, 2).error().text.rfind("--kill '7@5'", 0) == 0);
  CHECK(net::parse_trouble(wrong, deaths, 2).error().text.rfind("--partition '7@5'", 0) == 0);
}
