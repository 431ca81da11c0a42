// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/point_to_plane.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "mapper/align/pose_step.hpp"

using namespace g3d;
using namespace g3d::mapper::align;

namespace {

/// The inside of a corner: x = 2, y = 2 and z = 2 of the camera's own frame, one metre of each.
std::vector<DepthSample> corner(int per_wall) {
  hal::SeededRandom random(2);
  std::vector<DepthSample> samples;
  for (std::size_t wall = 0; wall < 3; ++wall) {
    for (int i = 0; i < per_wall; ++i) {
      DepthSample sample{{}, {}, 0.5F};
      for (std::size_t k = 0; k < 3; ++k) sample.point_m[k] = 0.97F + static_cast<float>(random.uniform());
      sample.point_m[wall] = 2.0F + 0.01F;
      sample.normal[wall] = -1.0F;
      samples.push_back(sample);
    }
  }
  return samples;
}

double cost_of(const NormalSums& sums) { return static_cast<double>(sums.cost) * 0x1.0p-40; }

}  // namespace

TEST_CASE("the gradient is the derivative of the cost", "[mapper][align]") {
  SurfaceMap surfaces({.rule = {.cell_m = 0.05F}, .slots = 1U << 14});
  const auto samples = corner(20000);
  surfaces.add(samples, {});
  const auto few = corner(400);
  // A kernel so wide that the cost is the plain square.
  constexpr float kWide_m = 10.0F;
  const hal::Pose at = moved({}, {0.004, -0.003, 0.002, 0.001, -0.002, 0.001});
  const NormalSums sums = match(few, surfaces, at, kWide_m);
  REQUIRE(sums.matched > 1000);
  const Vector6 gradient = sums.gradient_vector();
  for (std::size_t axis = 0; axis < 6; ++axis) {
    constexpr double kStep = 1e-3;
    Vector6 x{};
    x[axis] = kStep;
    const double above = cost_of(match(few, surfaces, moved(at, x), kWide_m));
    x[axis] = -kStep;
    const double below = cost_of(match(few, surfaces, moved(at, x), kWide_m));
    INFO("axis " << axis);
    CHECK(gradient[axis] == Approx((above - below) / (4.0 * kStep)).epsilon(0.02).margin(0.02));
  }
}

TEST_CASE("a few steps find a pose that was off", "[mapper][align]") {
  SurfaceMap surfaces({.rule = {.cell_m = 0.05F}, .slots = 1U << 14});
  surfaces.add(corner(20000), {});
  const auto samples = corner(400);
  hal::Pose pose = moved({}, {0.02, -0.015, 0.01, 0.004, 0.008, -0.006});
  for (int step = 0; step < 6; ++step) {
    const NormalSums sums = match(samples, surfaces, pose, 0.05F);
    Vector6 x{};
    Vector6 b = sums.gradient_vector();
    for (double& v : b) v = -v;
    REQUIRE(solve(sums.matrix(), b, x));
    pose = moved(pose, x);
  }
  const Vector6 off = difference({}, pose);
  CHECK(shift_of(off) < 0.001);
  CHECK(turn_of(off) < 0.0007);
}

TEST_CASE("a sample without a surface of its own pulls nowhere", "[mapper][align]") {
  SurfaceMap surfaces({.rule = {.cell_m = 0.05F}, .slots = 1U << 14});
  surfaces.add(corner(20000), {});
  std::vector<DepthSample> odd{{{2.0F, 1.5F, 1.5F}, {0.0F, 0.0F, -1.0F}, 0.5F},
                               {{9.0F, 1.5F, 1.5F}, {-1.0F, 0.0F, 0.0F}, 0.5F}};
  const NormalSums sums = match(odd, surfaces, {}, 0.05F);
  CHECK(sums.matched == 0);
  CHECK(sums.cost == 0);
  CHECK(sums.gradient == std::array<std::int64_t, 6>{});
}
