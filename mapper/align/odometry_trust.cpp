// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/odometry_trust.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace g3d::mapper::align {
namespace {

constexpr double kLong_s = 30.0;
constexpr double kShort_s = 2.0;
// A robot that looks around first turns through all that its map begins with: what the image pulls to one side then
// stays. So odometry is taken to be good at first; a bad one shows within a second.
constexpr double kFirstScale = 0.1;
constexpr double kFirstDoubt_s = 0.5;
constexpr double kNoise = 1.0;  // by which the mean of two seconds may exceed the true one
// An image's samples err together: measured over drives of exact odometry, at 160x120 and at 640x480, innovations are
// 2.5 to 3.7 times as large in the mean square as the sums of their least squares say.
constexpr double kImageVariance = 3.0;
constexpr double kMostOutlier = 16.0;
constexpr double kLeastScale = 0.01;
constexpr double kMostScale = 1.0;                     // what surprises most is people, who are not to be followed
constexpr std::array<std::size_t, 3> kFloor{0, 1, 5};  // x, y, heading

using Matrix3 = std::array<double, 9>;

Matrix3 floor_of(const Matrix6& m) {
  Matrix3 f{};
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) f[3 * a + b] = m[6 * kFloor[a] + kFloor[b]];
  }
  return f;
}

/// By cofactors, of a symmetric matrix; no library, whose order of operations differs between processors. False if it
/// has none.
bool invert(const Matrix3& m, Matrix3& inverse) {
  const double c0 = m[4] * m[8] - m[5] * m[7];
  const double c1 = m[5] * m[6] - m[3] * m[8];
  const double c2 = m[3] * m[7] - m[4] * m[6];
  const double determinant = m[0] * c0 + m[1] * c1 + m[2] * c2;
  if (!(determinant > 0.0)) return false;
  inverse = {c0, m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
             c1, m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
             c2, m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
  for (double& v : inverse) v /= determinant;
  return true;
}

std::array<double, 3> times(const Matrix3& m, const std::array<double, 3>& v) {
  std::array<double, 3> r{};
  for (std::size_t a = 0; a < 3; ++a) r[a] = m[3 * a] * v[0] + m[3 * a + 1] * v[1] + m[3 * a + 2] * v[2];
  return r;
}

}  // namespace

double OdometryTrust::turn_scale() const {
  if (known_s_ == 0.0) return kFirstScale;
  return std::clamp(std::max(long_.own2 / long_.model2, short_.own2 / short_.model2 - kNoise), kLeastScale, kMostScale);
}

void OdometryTrust::learn(const Vector6& correction, const Matrix6& information, const Matrix6& used,
                          const Matrix6& model, double time_s) {
  Matrix3 of_image{};
  Matrix3 of_model{};
  if (!invert(floor_of(information), of_image) || !invert(floor_of(model), of_model)) return;
  const std::array<double, 3> x{correction[kFloor[0]], correction[kFloor[1]], correction[kFloor[2]]};
  const std::array<double, 3> pulled = times(of_image, times(floor_of(used), x));
  const double image2 = of_image[8];
  const double model2 = of_model[8];
  if (!(image2 > 0.0 && model2 > 0.0) || image2 > model2) return;  // the image does not say
  const double innovation = x[2] + pulled[2];
  const double most2 = kMostOutlier * (kImageVariance * image2 + model2);
  const double own2 = std::min(innovation * innovation, most2) - kImageVariance * image2;
  if (known_s_ == 0.0) {
    long_ = short_ = {kFirstScale * model2, model2};
    known_s_ = kFirstDoubt_s;
  }
  known_s_ = std::min(known_s_ + time_s, kLong_s);
  const auto take = [&](Mean& mean, double memory_s) {
    const double share = std::min(1.0, time_s / memory_s);
    mean.own2 += share * (own2 - mean.own2);
    mean.model2 += share * (model2 - mean.model2);
  };
  take(long_, known_s_);
  take(short_, kShort_s);
}

OdometryNoise OdometryTrust::scaled(const OdometryNoise& model) const {
  OdometryNoise noise = model;
  const double turn = __builtin_sqrt(turn_scale());
  noise.turn_bias_rad_per_s *= turn;
  noise.turn_walk_rad_per_root_s *= turn;
  return noise;
}

}  // namespace g3d::mapper::align
