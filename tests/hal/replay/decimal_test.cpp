// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/decimal.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace g3d::hal;

TEST_CASE("Stamps are parsed to the nanosecond, without a double in between") {
  CHECK(parse_stamp_ns("1305031230.965035") == 1305031230965035000);
  CHECK(parse_stamp_ns("1305031230.123456789") == 1305031230123456789);
  CHECK(parse_stamp_ns("1305031230.1234567894") == 1305031230123456789);
  CHECK(parse_stamp_ns("1305031230.1234567895") == 1305031230123456790);
  CHECK(parse_stamp_ns("0.000000") == 0);
  CHECK(parse_stamp_ns("0.033333") == 33333000);
  CHECK(parse_stamp_ns("7") == 7'000'000'000);
  CHECK(parse_stamp_ns("7.") == 7'000'000'000);
  CHECK(parse_stamp_ns(".5") == 500'000'000);
  CHECK(parse_stamp_ns("-0.5") == -500'000'000);
  CHECK(parse_stamp_ns("+2") == 2'000'000'000);
  CHECK(parse_stamp_ns("000000000000000000000000012.5") == 12'500'000'000);
  CHECK(parse_stamp_ns("0.0000000005") == 1);
  CHECK(parse_stamp_ns("0.00000000049") == 0);
}

TEST_CASE("Stamps with an exponent, as numpy writes them") {
  CHECK(parse_stamp_ns("1.305031230965035e+09") == 1305031230965035000);
  CHECK(parse_stamp_ns("1e9") == 1'000'000'000'000'000'000);
  CHECK(parse_stamp_ns("12345E-3") == 12'345'000'000);
  CHECK(parse_stamp_ns("5e-10") == 1);
  CHECK(parse_stamp_ns("1e-30") == 0);
  CHECK(parse_stamp_ns("0e40") == 0);
}

TEST_CASE("What is no stamp, or too large a one, is refused") {
  for (const char* text : {"", "-", ".", "e5", "1e", "1e+", "1.2.3", "12a", "nan", "inf", "0x10", "1 2", "4000000001",
                           "99999999999999999999999", "1e10", "1e41", "1e999999999999", "--1", "1e+-5"}) {
    INFO(text);
    CHECK_FALSE(parse_stamp_ns(text).has_value());
  }
  CHECK(parse_stamp_ns("4000000000") == 4'000'000'000'000'000'000);
}

TEST_CASE("format_stamp and parse_stamp_ns are inverse") {
  CHECK(format_stamp(1305031230965035000) == "1305031230.965035000");
  CHECK(format_stamp(-1) == "-0.000000001");
  std::mt19937_64 rng(9);
  for (int i = 0; i < 2000; ++i) {
    const TimeNs stamp_ns = static_cast<TimeNs>(rng() % 8'000'000'000'000'000'000U) - 4'000'000'000'000'000'000;
    REQUIRE(parse_stamp_ns(format_stamp(stamp_ns)) == stamp_ns);
  }
}

TEST_CASE("Numbers must be numbers to their last letter") {
  CHECK(parse_double("-1.5e-3") == -1.5e-3);
  CHECK(parse_double("+2") == 2.0);
  CHECK(std::isnan(*parse_double("nan")));
  CHECK(std::isnan(*parse_double("-nan")));
  CHECK(std::isinf(*parse_double("inf")));
  CHECK_FALSE(parse_double("").has_value());
  CHECK_FALSE(parse_double("1,5").has_value());
  CHECK_FALSE(parse_double("1e999").has_value());
  CHECK_FALSE(parse_double("+-1").has_value());
  CHECK(parse_int("640") == 640);
  CHECK_FALSE(parse_int("640.0").has_value());
  CHECK_FALSE(parse_int("99999999999").has_value());
}

TEST_CASE("Lines are counted, comments and empty ones skipped, carriage returns dropped") {
  LineReader lines("# one\r\n\n  two words \r\n   # three\nlast");
  CHECK(lines.next() == "two words");
  CHECK(lines.line_number() == 3);
  CHECK(lines.next() == "last");
  CHECK(lines.line_number() == 5);
  CHECK_FALSE(lines.next().has_value());
  std::string_view rest = "  a\tb  c ";
  CHECK(take_word(rest) == "a");
  CHECK(rest == "b  c");
  CHECK(take_word(rest) == "b");
  CHECK(take_word(rest) == "c");
  CHECK(take_word(rest).empty());
}
