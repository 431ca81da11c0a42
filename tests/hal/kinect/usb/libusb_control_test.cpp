// SPDX-License-Identifier: Apache-2.0
#include <catch2/catch.hpp>

#include "hal/kinect/tilt_unit.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect;

TEST_CASE("a foot that is not there, or no USB at all, is an error with a reason, again and again") {
  for (int i = 0; i < 3; ++i) {
    const auto usb = open_usb_control(kMicrosoft, kKinectFoot);
    if (usb.ok()) {
      WARN("there is a Kinect at this machine");
      return;
    }
    CHECK_FALSE(usb.error().text.empty());
    CHECK(usb.error().reason != Reason::bad_usage);
  }
}
