// SPDX-License-Identifier: Apache-2.0
// What holds with and without OpenNI2.
#include <catch2/catch.hpp>

#include "hal/kinect/openni_parts.hpp"
#include "hal/kinect/usb_control.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("a Kinect is there only in a program that was built with OpenNI2, and else says how to get it") {
  const RealClock clock;
  const auto link = make_freenect_link(clock, {});
  CHECK(link.ok() == is_openni_built_in());
  const auto recording = open_recording("/none/a.oni", nullptr);
  REQUIRE_FALSE(recording.ok());
  CHECK(recording.error().reason == (is_openni_built_in() ? Reason::not_found : Reason::unsupported));
  // A vendor that nobody is.
  const auto usb = open_usb_control(0xFFFF, 0xFFFE);
  REQUIRE_FALSE(usb.ok());
  CHECK((usb.error().reason == Reason::not_found || usb.error().reason == Reason::unsupported));
  if (is_openni_built_in()) return;
  CHECK_THAT(link.error().text, Catch::Contains("scripts/static_libs"));
}
