// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/plain_trig.hpp"

#include <cstdint>

namespace g3d::hal {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295769;

// Taylor series on [-45, 45] degrees: the first term left out is below 1e-17.
double sin_series(double x) {
  const double q = x * x;
  double sum = 0.0;
  for (int n = 17; n >= 3; n -= 2) sum = (sum + 1.0) * (-q / (n * (n - 1)));
  return x * (1.0 + sum);
}

double cos_series(double x) {
  const double q = x * x;
  double sum = 0.0;
  for (int n = 18; n >= 2; n -= 2) sum = (sum + 1.0) * (-q / (n * (n - 1)));
  return 1.0 + sum;
}

}  // namespace

SinCos sin_cos_deg(double angle_deg) {
  const double turns = angle_deg / 90.0;
  const auto quarter = static_cast<std::int64_t>(turns < 0.0 ? turns - 0.5 : turns + 0.5);
  const double rest_rad = (angle_deg - 90.0 * static_cast<double>(quarter)) * kRadPerDeg;
  const double s = sin_series(rest_rad);
  const double c = cos_series(rest_rad);
  switch (quarter & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace g3d::hal
