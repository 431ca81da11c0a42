// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/gpio_log.hpp"

#include <array>
#include <catch2/catch.hpp>

using namespace g3d::hal;

TEST_CASE("A GPIO log is read as it was written", "[gpio]") {
  std::string text = "# edges\n";
  std::array<char, kMaxGpioLogLine> line{};
  text.append(line.data(), format_gpio_line_to(line.data(), 12'345, "estop", true));
  text.append(line.data(), format_gpio_line_to(line.data(), 12'345, "17", false));
  CHECK(text == "# edges\n12345 estop 1\n12345 17 0\n");
  const auto log = parse_gpio_log(text + "9999", "x");
  REQUIRE(log.ok());
  CHECK(log.value().records == std::vector<GpioRecord>{{12'345, "estop", true}, {12'345, "17", false}});
  CHECK(log.value().torn_bytes == 4);
  CHECK(format_gpio_line_to(line.data(), INT64_MIN, std::string(100, 'x'), true) <= kMaxGpioLogLine);
}

TEST_CASE("A bad GPIO log names file and line", "[gpio]") {
  const auto reason = [](std::string_view text) {
    const auto log = parse_gpio_log(text, "g.log");
    REQUIRE_FALSE(log.ok());
    CHECK(log.error().reason == Reason::malformed);
    return log.error().text;
  };
  CHECK(reason("1 a 1\nx a 1\n").find("g.log:2: a line that does not begin with nanoseconds") == 0);
  CHECK(reason("1 a\n").find("has not three words") != std::string::npos);
  CHECK(reason("1 a 2\n").find("does not end with 0 or 1") != std::string::npos);
  CHECK(reason("1 a b 1\n").find("has no line's name") != std::string::npos);
  CHECK(reason("2 a 1\n1 a 1\n").find("g.log:2: a line that is earlier") == 0);
  CHECK(reason("99999999999999999999 a 1\n").find("does not begin") != std::string::npos);
  CHECK_FALSE(read_gpio_log("/nonexistent").ok());
}

TEST_CASE("Replayed lines change when their time has come", "[gpio]") {
  const auto log = parse_gpio_log("10 estop 1\n20 other 0\n30 estop 0\n", "x");
  REQUIRE(log.ok());
  DataClock clock;
  ReplayedGpio lines(log.value(), clock, {"estop", ""});
  CHECK(lines.input_count() == 1);
  GpioEdge edge;
  CHECK_FALSE(lines.read_edge(edge, 0));
  CHECK_FALSE(lines.level(0));
  clock.advance_to(25);
  REQUIRE(lines.read_edge(edge, 25));
  CHECK(edge == GpioEdge{10, 0, true});
  CHECK(lines.level(0) == true);
  CHECK_FALSE(lines.read_edge(edge, 25));
  clock.advance_to(30);
  REQUIRE(lines.read_edge(edge, 30));
  CHECK(lines.level(0) == false);
  CHECK(lines.is_over());
  CHECK(lines.counts().edges == 2);
}
