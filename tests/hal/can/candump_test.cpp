// SPDX-License-Identifier: Apache-2.0
#include "hal/can/candump.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <string>

using namespace g3d::hal;
using namespace g3d::hal::can;

namespace {

std::string written(const StampedCanFrame& stamped, std::string_view interface = "can0") {
  std::array<char, kMaxCandumpLine> line{};
  return {line.data(), format_candump_to(line.data(), stamped, interface)};
}
BadCandump bad(std::string_view line) { return parse_candump(line).bad; }

}  // namespace

TEST_CASE("Lines of candump are read as candump means them", "[can]") {
  const CandumpLine plain = parse_candump("(1436509052.249713) vcan0 044#2A366C2BBA");
  REQUIRE(plain.bad == BadCandump::none);
  CHECK(plain.interface == "vcan0");
  CHECK(plain.stamped.t_ns == 1436509052'249713000);
  CHECK(plain.stamped.frame.id == 0x44);
  CHECK(plain.stamped.frame.size == 5);
  CHECK(plain.stamped.frame.data == std::array<std::uint8_t, 8>{0x2A, 0x36, 0x6C, 0x2B, 0xBA, 0, 0, 0});
  CHECK_FALSE(plain.stamped.frame.is_extended);

  const CandumpLine extended = parse_candump("(0.000001) can1 1F334455#1122334455667788");
  REQUIRE(extended.bad == BadCandump::none);
  CHECK(extended.stamped.frame.is_extended);
  CHECK(extended.stamped.frame.id == 0x1F334455);
  CHECK(extended.stamped.t_ns == 1'000);

  const CandumpLine error = parse_candump("(12.000000) can0 20000040#0000000000000000");
  REQUIRE(error.bad == BadCandump::none);
  CHECK(error.stamped.frame.is_error);
  CHECK(error.stamped.frame.id == 0x40);

  const CandumpLine remote = parse_candump("(12.000000) can0 123#R4");
  REQUIRE(remote.bad == BadCandump::none);
  CHECK(remote.stamped.frame.is_remote);
  CHECK(remote.stamped.frame.size == 4);
  CHECK(parse_candump("(12.000000) can0 123#R").bad == BadCandump::none);
  CHECK(parse_candump("(12.000000) can0 123#").stamped.frame.size == 0);
  CHECK(parse_candump("(12.000000) can0 123#11 R").bad == BadCandump::none);
}

TEST_CASE("What is written is read again", "[can]") {
  CanFrame frame;
  frame.id = 0x711;
  frame.size = 1;
  frame.data[0] = 5;
  CHECK(written({1'500'123'456, frame}) == "(1.500123) can0 711#05\n");
  for (const int kind : {0, 1, 2, 3}) {
    frame.is_extended = kind == 1;
    frame.is_error = kind == 2;
    frame.is_remote = kind == 3;
    if (kind == 3) frame.data = {};
    const std::string line = written({1'500'123'000, frame});
    const CandumpLine read = parse_candump(std::string_view(line).substr(0, line.size() - 1));
    REQUIRE(read.bad == BadCandump::none);
    CHECK(read.stamped == StampedCanFrame{1'500'123'000, frame});
  }
  // The longest line fits.
  CanFrame longest;
  longest.is_extended = true;
  longest.id = kMaxExtendedId;
  longest.size = 8;
  CHECK(written({INT64_MAX, longest}, "averyverylongname0").size() <= kMaxCandumpLine);
}

TEST_CASE("A bad line says which part of it is", "[can]") {
  CHECK(bad("") == BadCandump::stamp);
  CHECK(bad("1.000000 can0 123#") == BadCandump::stamp);
  CHECK(bad("(1.000) can0 123#") == BadCandump::stamp);
  CHECK(bad("(-1.000000) can0 123#") == BadCandump::stamp);
  CHECK(bad("(99999999999.000000) can0 123#") == BadCandump::stamp);
  CHECK(bad("(.000000) can0 123#") == BadCandump::stamp);
  CHECK(bad("(1.000000) ") == BadCandump::interface);
  CHECK(bad("(1.000000) averyverylongname0 123#") == BadCandump::interface);
  CHECK(bad("(1.000000) can0 123") == BadCandump::identifier);
  CHECK(bad("(1.000000) can0 1234#") == BadCandump::identifier);
  CHECK(bad("(1.000000) can0 800#") == BadCandump::identifier);
  CHECK(bad("(1.000000) can0 F2345678#") == BadCandump::identifier);
  CHECK(bad("(1.000000) can0 12G#") == BadCandump::identifier);
  CHECK(bad("(1.000000) can0 123#1") == BadCandump::data);
  CHECK(bad("(1.000000) can0 123#112233445566778899") == BadCandump::data);
  CHECK(bad("(1.000000) can0 123#XY") == BadCandump::data);
  CHECK(bad("(1.000000) can0 123#R9") == BadCandump::data);
  CHECK(bad("(1.000000) can0 123##111") == BadCandump::flexible);
  CHECK(bad("(1.000000) can0 123#11 what") == BadCandump::rest);
  CHECK(bad("(1.000000) can0 123#R12") == BadCandump::rest);
}
