// SPDX-License-Identifier: Apache-2.0
// Sine and cosine of an angle in degrees from + - * / alone: the C library's differ in the last digit from machine to
// machine, and a simulated drive must give the same map everywhere.
#pragma once

namespace g3d::hal {

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

/// |angle| up to 1e6 degrees; error below 1e-15. Multiples of 90 degrees are exact.
[[nodiscard]] SinCos sin_cos_deg(double angle_deg);

}  // namespace g3d::hal
