// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/session.hpp"

#include <catch2/catch.hpp>

using namespace g3d::hal;
using namespace g3d::hal::kinect::openni;

TEST_CASE("who holds OpenNI2 has it alone, until it is given back") {
  struct Silence final : g3d::hal::kinect::ImageSink {
    void take(const g3d::hal::kinect::SensorImage& /*image*/) override {}
  } silence;
  const RealClock clock;
  {
    const auto first = Session::begin(Driver::oni_file, silence, clock);
    REQUIRE(first.ok());
    CHECK(Session::begin(Driver::virtual_kinect, silence, clock).error().reason == Reason::no_capacity);
  }
  CHECK(Session::begin(Driver::virtual_kinect, silence, clock).ok());
}
