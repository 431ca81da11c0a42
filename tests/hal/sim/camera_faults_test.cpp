// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/camera_faults.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/frame_pool.hpp"
#include "hal/sim/sim_building.hpp"

using namespace g3d::hal;

namespace {

const CameraModel kCamera = scaled_kinect(32, 24);

struct Shown {
  bool comes;
  TimeNs stamp_ns;
  std::uint16_t depth;
};

/// Frame i has stamp i and depth 1000 + i everywhere.
std::vector<Shown> through(FaultKind fault, int frames) {
  CameraFaults faults(kCamera, 1);
  faults.set(fault);
  Frame frame = make_frame(kCamera);
  std::vector<Shown> out;
  for (int i = 0; i < frames; ++i) {
    std::fill_n(frame.depth.get(), kCamera.pixel_count(), static_cast<std::uint16_t>(1000 + i));
    frame.stamp_ns = i;
    const bool comes = faults.apply(frame);
    out.push_back({comes, frame.stamp_ns, frame.depth[100]});
  }
  return out;
}

long coming(const std::vector<Shown>& shown) {
  return std::count_if(shown.begin(), shown.end(), [](const Shown& s) { return s.comes; });
}

}  // namespace

TEST_CASE("a good camera's frames pass, a dead one's do not") {
  const auto good = through(FaultKind::none, 30);
  CHECK(coming(good) == 30);
  CHECK(good[7].depth == 1007);
  CHECK(coming(through(FaultKind::off, 30)) == 0);
}

TEST_CASE("a stuck camera shows one image with new stamps") {
  for (const Shown& s : through(FaultKind::stuck, 5)) CHECK(s.depth == 1000);
  CHECK(through(FaultKind::stuck, 5)[4].stamp_ns == 4);
}

TEST_CASE("a slow camera and one with a loose contact lose frames") {
  CHECK(coming(through(FaultKind::slow, 100)) == 10);
  const auto loose = through(FaultKind::intermittent, 40);
  CHECK(coming(loose) == 20);
  CHECK_FALSE(loose[9].comes);
  CHECK(loose[10].comes);
  CHECK_FALSE(loose[20].comes);
}

TEST_CASE("a late camera shows what was, and says when") {
  const auto late = through(FaultKind::delayed, 40);
  CHECK(coming(late) == 30);
  CHECK(late[15].comes);
  CHECK(late[15].stamp_ns == 5);
  CHECK(late[15].depth == 1005);
}

TEST_CASE("a wrong camera reads too far, one full of garbage anything") {
  CHECK(through(FaultKind::wrong, 1)[0].depth == 1500);
  CameraFaults faults(kCamera, 1);
  faults.set(FaultKind::garbage);
  Frame frame = make_frame(kCamera);
  REQUIRE(faults.apply(frame));
  const auto [low, high] = std::minmax_element(frame.depth.get(), frame.depth.get() + kCamera.pixel_count());
  CHECK(*high - *low > 5000);
}
