// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/text_fields.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace g3d::hal;

TEST_CASE("lines are split into words, comments and blank lines left out") {
  const auto lines = split_lines("a b\t c  # rest\n\n   # only\n\r\nd#e\r\nlast", "f");
  REQUIRE(lines);
  REQUIRE(lines.value().size() == 3);
  CHECK(lines.value()[0].words() == std::vector<std::string_view>{"a", "b", "c"});
  CHECK(lines.value()[0].number() == 1);
  CHECK(lines.value()[1].words() == std::vector<std::string_view>{"d#e"});  // colours hold a # inside of a word
  CHECK(lines.value()[1].number() == 5);
  CHECK(lines.value()[2].number() == 6);
}

TEST_CASE("binary and oversized text is refused") {
  using namespace std::string_view_literals;
  const auto binary = split_lines("box 1\nab\0c"sv, "f");
  REQUIRE_FALSE(binary.ok());
  CHECK(binary.error().text.find("f:2:") == 0);
  const auto large = split_lines(std::string(kMaxTextBytes + 1, ' '), "f");
  REQUIRE_FALSE(large.ok());
  CHECK(large.error().reason == Reason::too_large);
}

TEST_CASE("numbers fill the whole word and are finite") {
  CHECK(parse_number("-1.5e2") == -150.0);
  CHECK(parse_number("+3") == 3.0);
  for (const char* bad : {"", "1x", "nan", "inf", "1e999", "0x10", "1,5", "--1", "+"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_number(bad).has_value());
  }
}

TEST_CASE("a number out of range is told with file, line and range") {
  const auto lines = split_lines("\nx", "w.world");
  const TextLine& line = lines.value()[0];
  CHECK(line.number_in("2", "radius", 0.0, 2.0).value() == 2.0);
  const auto bad = line.number_in("2.5", "radius", 0.0, 2.0);
  REQUIRE_FALSE(bad.ok());
  CHECK(bad.error().reason == Reason::out_of_range);
  CHECK(bad.error().text == "w.world:2: radius is 2.5, allowed are 0 to 2");
  CHECK(line.number_in("two", "radius", 0.0, 2.0).error().reason == Reason::malformed);
}
