// SPDX-License-Identifier: Apache-2.0
// Written out: a library's products may be vectorised in another order on another processor.
#include "mapper/align/normal_equations.hpp"

#include <cmath>

namespace g3d::mapper::align {
namespace {
constexpr double kCoarseUnit = 0x1.0p-20;
}  // namespace

Matrix6 NormalSums::matrix() const {
  Matrix6 m{};
  std::size_t at = 0;
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = a; b < 6; ++b) m[6 * a + b] = m[6 * b + a] = static_cast<double>(upper[at++]) * kCoarseUnit;
  }
  return m;
}

Vector6 NormalSums::gradient_vector() const {
  Vector6 g{};
  for (std::size_t a = 0; a < 6; ++a) g[a] = static_cast<double>(gradient[a]) * kCoarseUnit;
  return g;
}

bool solve(const Matrix6& a, const Vector6& b, Vector6& x) {
  Matrix6 l{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double s = a[6 * i + j];
      for (std::size_t k = 0; k < j; ++k) s -= l[6 * i + k] * l[6 * j + k];
      if (i != j) {
        l[6 * i + j] = s / l[6 * j + j];
        continue;
      }
      if (!(s > 0.0)) return false;
      l[6 * i + i] = std::sqrt(s);
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    double s = b[i];
    for (std::size_t k = 0; k < i; ++k) s -= l[6 * i + k] * x[k];
    x[i] = s / l[6 * i + i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    double s = x[i];
    for (std::size_t k = i + 1; k < 6; ++k) s -= l[6 * k + i] * x[k];
    x[i] = s / l[6 * i + i];
  }
  return true;
}

double quadratic(const Matrix6& a, const Vector6& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) sum += x[i] * a[6 * i + j] * x[j];
  }
  return sum;
}

}  // namespace g3d::mapper::align
