// SPDX-License-Identifier: Apache-2.0
// The sums of a least-squares problem in six unknowns, x = (rho, theta): a small shift in metres and a small turn in
// radians about the camera, both along the world's axes.
//
// Terms are rounded to integers before they are summed, so that the sum is the same in any order and on any machine:
// what lets a card add them up with atomics and agree with the CPU to the last bit. Inline, as a card runs these lines
// as well (mapper/cuda/kernels.cu), and written out: a library's products may be vectorised in another order on another
// processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::mapper::align {

using Vector6 = std::array<double, 6>;
using Matrix6 = std::array<double, 36>;  // row-major, symmetric

struct NormalSums {
  std::array<std::int64_t, 21> upper{};    ///< upper triangle of J^T W J row by row, in 2^-20
  std::array<std::int64_t, 6> gradient{};  ///< J^T W r, in 2^-20
  std::int64_t square = 0;                 ///< r W r, in 2^-40
  std::int64_t cost = 0;                   ///< what a robust kernel makes of r W r, in 2^-40
  std::int64_t matched = 0;                ///< residuals added

  /// `j`: derivative of the residual by x, below about 10; `residual` in metres; `weight` 0..1.
  void add(const std::array<float, 6>& j, float residual, float weight) {
    std::size_t at = 0;
#pragma GCC unroll 6
    for (std::size_t a = 0; a < 6; ++a) {
      const float wj = weight * j[a];
#pragma GCC unroll 6
      for (std::size_t b = a; b < 6; ++b) upper[at++] += static_cast<std::int64_t>(wj * j[b] * kCoarse);
      gradient[a] += static_cast<std::int64_t>(wj * residual * kCoarse);
    }
    square += static_cast<std::int64_t>(weight * residual * residual * kFine);
    ++matched;
  }
  void add_cost(float term) { cost += static_cast<std::int64_t>(term * kFine); }

  [[nodiscard]] Matrix6 matrix() const;
  [[nodiscard]] Vector6 gradient_vector() const;
  /// Of the weighted residuals, square metres; 0 without any. The mean cost is of the same kind, but bounded.
  [[nodiscard]] double mean_square() const { return mean(square); }
  [[nodiscard]] double mean_cost() const { return mean(cost); }

 private:
  [[nodiscard]] double mean(std::int64_t fine_sum) const {
    return matched == 0 ? 0.0 : static_cast<double>(fine_sum) * 0x1.0p-40 / static_cast<double>(matched);
  }
  static constexpr float kCoarse = 1048576.0F;          // 2^20
  static constexpr float kFine = 1048576.0F * kCoarse;  // residuals are millimetres, their squares are small
};

/// x with A x = b for a symmetric positive definite A (Cholesky). False if A is not.
[[nodiscard]] inline bool solve(const Matrix6& a, const Vector6& b, Vector6& x);
/// x^T A x
[[nodiscard]] inline double quadratic(const Matrix6& a, const Vector6& x);

inline Matrix6 NormalSums::matrix() const {
  Matrix6 m{};
  std::size_t at = 0;
#pragma GCC unroll 6
  for (std::size_t a = 0; a < 6; ++a) {
#pragma GCC unroll 6
    for (std::size_t b = a; b < 6; ++b) m[6 * a + b] = m[6 * b + a] = static_cast<double>(upper[at++]) * 0x1.0p-20;
  }
  return m;
}

inline Vector6 NormalSums::gradient_vector() const {
  Vector6 g{};
  for (std::size_t a = 0; a < 6; ++a) g[a] = static_cast<double>(gradient[a]) * 0x1.0p-20;
  return g;
}

inline bool solve(const Matrix6& a, const Vector6& b, Vector6& x) {
  Matrix6 l{};
  // Unrolled, since what is indexed by a variable is no register of a card's.
#pragma GCC unroll 6
  for (std::size_t i = 0; i < 6; ++i) {
#pragma GCC unroll 6
    for (std::size_t j = 0; j <= i; ++j) {
      double s = a[6 * i + j];
#pragma GCC unroll 6
      for (std::size_t k = 0; k < j; ++k) s -= l[6 * i + k] * l[6 * j + k];
      if (i != j) {
        l[6 * i + j] = s / l[6 * j + j];
        continue;
      }
      if (!(s > 0.0)) return false;
      l[6 * i + i] = __builtin_sqrt(s);
    }
  }
#pragma GCC unroll 6
  for (std::size_t i = 0; i < 6; ++i) {
    double s = b[i];
#pragma GCC unroll 6
    for (std::size_t k = 0; k < i; ++k) s -= l[6 * i + k] * x[k];
    x[i] = s / l[6 * i + i];
  }
#pragma GCC unroll 6
  for (std::size_t i = 6; i-- > 0;) {
    double s = x[i];
#pragma GCC unroll 6
    for (std::size_t k = i + 1; k < 6; ++k) s -= l[6 * k + i] * x[k];
    x[i] = s / l[6 * i + i];
  }
  return true;
}

inline double quadratic(const Matrix6& a, const Vector6& x) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) sum += x[i] * a[6 * i + j] * x[j];
  }
  return sum;
}

}  // namespace g3d::mapper::align
