// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/can_log.hpp"

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using namespace g3d::hal;

TEST_CASE("A CAN log is read whole, but for half a line at its end", "[can]") {
  const auto log =
      parse_can_log("# comment\n(1.000000) can0 711#05\r\n\n(1.000000) can0 091#0000000000000000\n(2.0", "x");
  REQUIRE(log.ok());
  CHECK(log.value().frames.size() == 2);
  CHECK(log.value().interface == "can0");
  CHECK(log.value().torn_bytes == 4);
  CHECK(parse_can_log("", "x").value().frames.empty());
}

TEST_CASE("A bad CAN log names file and line", "[can]") {
  const auto reason = [](std::string_view text) {
    const auto log = parse_can_log(text, "bus.log");
    REQUIRE_FALSE(log.ok());
    return log.error().text;
  };
  CHECK(reason("(1.000000) can0 711#05\nnonsense\n").find("bus.log:2: a line that does not begin with") == 0);
  CHECK(reason("(2.000000) can0 711#05\n(1.000000) can0 711#05\n").find("bus.log:2: a frame earlier") == 0);
  CHECK(reason("(1.000000) can0 711#05\n(1.000000) can1 711#05\n").find("bus.log:2: a second interface") == 0);
  const auto missing = read_can_log("/nonexistent/can.log");
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().reason == Reason::not_found);
}

TEST_CASE("A replayed bus gives each frame when its time has come", "[can]") {
  const auto log = parse_can_log("(1.000000) can0 711#05\n(1.500000) can0 20000040#0000000000000000\n", "x");
  REQUIRE(log.ok());
  DataClock clock;
  ReplayedCan port(log.value(), clock);
  can::CanFrame frame;
  CHECK_FALSE(port.read(frame));
  clock.advance_to(1'000'000'000);
  REQUIRE(port.read(frame));
  CHECK(frame.id == 0x711);
  CHECK_FALSE(port.read(frame));
  CHECK_FALSE(port.is_over());
  clock.advance_to(9'000'000'000);
  REQUIRE(port.read(frame));
  CHECK(frame.is_error);
  CHECK(port.is_over());
  CHECK_FALSE(port.read(frame));
  CHECK(port.counts().received == 2);
  CHECK(port.counts().error_frames == 1);
  CHECK(port.write(frame));
  CHECK(port.counts().sent == 1);
}
