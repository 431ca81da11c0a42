// SPDX-License-Identifier: Apache-2.0
#include "hal/kinect/openni/driver_table.hpp"

#include <catch2/catch.hpp>

#include "hal/kinect/openni/session.hpp"

using namespace g3d::hal;
using namespace g3d::hal::kinect::openni;

namespace {

struct NoTap final : g3d::hal::kinect::ImageSink {
  void take(const g3d::hal::kinect::SensorImage& /*image*/) override {}
};

}  // namespace

TEST_CASE("each driver of the table can be started and ended, again and again; one that throws is an error") {
  NoTap tap;
  const RealClock clock;
  for (int round = 0; round < 3; ++round) {
    for (const Driver driver : {Driver::oni_file, Driver::virtual_kinect, Driver::freenect}) {
      const std::uint64_t exceptions = driver_exceptions();
      const auto session = Session::begin(driver, tap, clock);
      if (session.ok()) continue;
      // Where USB cannot start, libfreenect's driver throws.
      CHECK(driver == Driver::freenect);
      CHECK(session.error().reason == Reason::unsupported);
      CHECK(driver_exceptions() > exceptions);
      CHECK_FALSE(last_driver_exception().empty());
      CHECK_THAT(session.error().text, Catch::Contains(last_driver_exception()));
    }
  }
}
