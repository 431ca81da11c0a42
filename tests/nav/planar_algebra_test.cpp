// SPDX-License-Identifier: Apache-2.0
#include "nav/planar_algebra.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d;
using namespace g3d::nav;

namespace {

void check_same(const hal::PlanarPose& a, const hal::PlanarPose& b) {
  CHECK(a.x_m == Approx(b.x_m).margin(1e-12));
  CHECK(a.y_m == Approx(b.y_m).margin(1e-12));
  CHECK(std::remainder(a.heading_rad - b.heading_rad, 6.283185307179586) == Approx(0.0).margin(1e-12));
}

hal::Pose on_floor(const hal::PlanarPose& p) { return hal::from_xyz_rpy(p.x_m, p.y_m, 0, 0, 0, p.heading_rad); }

}  // namespace

TEST_CASE("planar poses compose as rigid ones do", "[nav]") {
  const hal::PlanarPose a{1.0, -2.0, 2.5};
  const hal::PlanarPose b{0.3, 0.4, 1.2};
  check_same(compose(a, b), on_plane(hal::compose(on_floor(a), on_floor(b))));
  check_same(compose(a, inverse(a)), {});
  check_same(compose(inverse(b), b), {});
  check_same(on_plane(on_floor(a)), a);
}
