// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/device_check.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace g3d::hal;
using namespace g3d::hal::kobuki;

Result<std::string> check(std::uint8_t major, std::uint8_t minor, std::uint8_t patch) {
  DeviceInfo info;
  info.has_firmware = true;
  info.firmware = {major, minor, patch};
  return check_device(info);
}

TEST_CASE("current firmware needs no word") {
  REQUIRE(check(1, 2, 0).ok());
  CHECK(check(1, 2, 0).value().empty());
  CHECK(check(1, 3, 7).value().empty());
}

TEST_CASE("older firmware gets a warning that says what it lacks") {
  REQUIRE(check(1, 1, 4).ok());
  CHECK(check(1, 1, 4).value().find("gains") != std::string::npos);
  CHECK(check(1, 1, 3).value().find("gyro") != std::string::npos);
  CHECK(check(1, 0, 0).value().find("1.0.0") != std::string::npos);
}

TEST_CASE("another major version is refused") {
  for (const std::uint8_t major : {0, 2, 255}) {
    const auto refused = check(major, 0, 0);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().reason == Reason::unsupported);
    CHECK(refused.error().text.find("install") != std::string::npos);
  }
}

TEST_CASE("names as the base's own tools print them") {
  CHECK(version_text({1, 0, 4}) == "1.0.4");
  CHECK(udid_text({98238259, 926504013, 1360618305}) == "98238259-926504013-1360618305");
}

}  // namespace
