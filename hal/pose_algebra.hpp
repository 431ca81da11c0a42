// SPDX-License-Identifier: Apache-2.0
// The algebra of rigid poses, written out in + - * / and sqrt: a library product may be vectorised in another order on
// another processor, and then the same log would give another map there. Inline, because a graphics card runs it as
// well (mapper/cuda/kernels.cu). Include hal/geometry.hpp, which says what the functions do.
#pragma once

#include <array>
#include <cstddef>

namespace g3d::hal::algebra {

using Vector3 = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  // x y z w
using Matrix3 = std::array<double, 9>;     // row-major

inline double dot(const Quaternion& a, const Quaternion& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

inline Quaternion scaled_to_unit(const Quaternion& q) {
  const double norm = __builtin_sqrt(dot(q, q));
  return {q[0] / norm, q[1] / norm, q[2] / norm, q[3] / norm};
}

inline Quaternion multiply(const Quaternion& a, const Quaternion& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
          a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

inline Matrix3 to_matrix(const Quaternion& q) {
  const auto [x, y, z, w] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
          2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
}

inline Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Matrix3 m = to_matrix(q);
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

}  // namespace g3d::hal::algebra
