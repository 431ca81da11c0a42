// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/motion_prior.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace g3d::mapper::align;

TEST_CASE("odometry is trusted less along a step than across it", "[mapper][align]") {
  const OdometryNoise noise;
  const double s = std::sqrt(0.5);
  const Matrix6 m = prior_information(noise, Motion::free, OdometrySource::measured, {s, s, 0.0}, 0.1);
  const double along = quadratic(m, {s, s, 0, 0, 0, 0});
  const double across = quadratic(m, {-s, s, 0, 0, 0, 0});
  const double walk2 = 0.002 * 0.002 * 0.1;
  CHECK(1.0 / along == Approx(walk2 + 0.03 * 0.03));
  CHECK(1.0 / across == Approx(walk2 + 0.01 * 0.01));
  CHECK(quadratic(m, {0, 0, 1, 0, 0, 0}) == Approx(across));
  for (std::size_t axis = 3; axis < 6; ++axis) {
    Vector6 x{};
    x[axis] = 1.0;
    CHECK(1.0 / quadratic(m, x) == Approx(0.0006 * 0.0006 + 0.01 * 0.01 * 0.1));
  }
}

TEST_CASE("a camera that stands still may still have been moved a little", "[mapper][align]") {
  const Matrix6 m = prior_information({}, Motion::free, OdometrySource::measured, {0, 0, 0}, 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) CHECK(m[7 * axis] == Approx(1.0 / (0.002 * 0.002)));
}

TEST_CASE("on a floor, height and tilt are held whatever the step", "[mapper][align]") {
  const Matrix6 m = prior_information({}, Motion::planar, OdometrySource::measured, {0.3, 0.1, 0.2}, 0.1);
  CHECK(1.0 / m[7 * 2] == Approx(0.001 * 0.001 * 0.1));
  CHECK(1.0 / m[7 * 3] == Approx(0.0015 * 0.0015 * 0.1));
  CHECK(m[7 * 3] == m[7 * 4]);
  CHECK(m[7 * 5] < m[7 * 3]);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < 6; ++k) CHECK(m[6 * i + k] == m[6 * k + i]);
  }
  CHECK(m[2] == 0.0);
  CHECK(m[1] != 0.0);
}

TEST_CASE("where nobody measures motion, the time says how far a camera can be", "[mapper][align]") {
  const Matrix6 m = prior_information({}, Motion::free, OdometrySource::none, {0, 0, 0}, 0.5);
  CHECK(1.0 / m[0] == Approx(0.35 * 0.35));
  CHECK(1.0 / m[7 * 5] == Approx(0.4 * 0.4));
}

TEST_CASE("the ways of moving have names", "[mapper][align]") {
  for (const Motion motion : {Motion::planar, Motion::free}) CHECK(motion_from_string(to_string(motion)) == motion);
  CHECK_FALSE(motion_from_string("flying"));
}
