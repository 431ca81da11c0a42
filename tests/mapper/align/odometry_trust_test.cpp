// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/odometry_trust.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/sample_maps.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

constexpr double kStep_s = 0.1;

/// Steps that odometry and the image err in by so much, and what a fit makes of them.
struct Steps {
  OdometryTrust trust;
  double odometry_rad = 0.0;
  double image_rad = 0.0006;
  double image_m = 0.0006;
  tests::Random random{3};

  static Matrix6 diagonal(double m, double rad) {
    Matrix6 matrix{};
    for (std::size_t i = 0; i < 6; ++i) matrix[7 * i] = 1.0 / (i < 3 ? m * m : rad * rad);
    return matrix;
  }
  double error(double sigma) { return sigma * random.uniform(-1.732, 1.732); }
  void on(double time_s) {
    const OdometryNoise noise;
    for (double t_s = 0.0; t_s < time_s; t_s += kStep_s) {
      const Matrix6 model = prior_information(noise, Motion::planar, OdometrySource::measured, {0.03, 0, 0}, kStep_s);
      const Matrix6 used =
          prior_information(trust.scaled(noise), Motion::planar, OdometrySource::measured, {0.03, 0, 0}, kStep_s);
      // The image errs by more than the sums say, as images do.
      const Matrix6 information = diagonal(image_m / std::sqrt(3.0), image_rad / std::sqrt(3.0));
      Vector6 correction{};
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{5}}) {
        const double innovation = i < 2 ? error(image_m) : error(odometry_rad) + error(image_rad);
        correction[i] = innovation * information[7 * i] / (information[7 * i] + used[7 * i]);
      }
      trust.learn(correction, information, used, model, kStep_s);
    }
  }
};

double model_turn_rad() {
  const OdometryNoise noise;
  return std::sqrt(noise.turn_walk_rad_per_root_s * noise.turn_walk_rad_per_root_s * kStep_s +
                   noise.turn_bias_rad_per_s * noise.turn_bias_rad_per_s * kStep_s * kStep_s);
}

}  // namespace

TEST_CASE("odometry that is as bad as it is said to be is trusted no more, one that is exact far more") {
  Steps as_stated;
  as_stated.odometry_rad = model_turn_rad();
  as_stated.on(1.5);
  CHECK(as_stated.trust.turn_scale() > 0.4);  // it shows soon
  as_stated.on(60.0);
  CHECK(as_stated.trust.turn_scale() > 0.75);

  Steps exact;
  exact.on(60.0);
  CHECK(exact.trust.turn_scale() < 0.04);
  const OdometryNoise scaled = exact.trust.scaled({});
  CHECK(scaled.turn_walk_rad_per_root_s < 0.25 * OdometryNoise{}.turn_walk_rad_per_root_s);
  CHECK(scaled.along_fraction == OdometryNoise{}.along_fraction);
  CHECK(scaled.tilt_rad_per_root_s == OdometryNoise{}.tilt_rad_per_root_s);
}

TEST_CASE("wheels that begin to slip, and a gyro that goes wrong, are noticed within seconds") {
  Steps steps;
  steps.on(120.0);
  REQUIRE(steps.trust.turn_scale() < 0.04);
  steps.odometry_rad = 4.0 * model_turn_rad();
  steps.on(1.5);
  CHECK(steps.trust.turn_scale() == 1.0);
  steps.odometry_rad = 0.0;
  steps.on(120.0);
  CHECK(steps.trust.turn_scale() < 0.1);
}

TEST_CASE("an image that says less than odometry teaches nothing, however it errs") {
  Steps corridor;
  corridor.image_m = 1.0;
  corridor.image_rad = 1.0;
  const double before = corridor.trust.turn_scale();
  corridor.on(30.0);
  CHECK(corridor.trust.turn_scale() == before);
  corridor.trust.learn({}, {}, {}, {}, 0.1);  // nothing is known at all
  CHECK(corridor.trust.turn_scale() == before);
}
