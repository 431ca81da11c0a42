// SPDX-License-Identifier: Apache-2.0
// What a fit of one frame to the surfaces starts from, one sample's part in it, and one step of it. Inline and without
// a library's mathematics: the CPU and a card run the same lines (see mapper/cuda/kernels.cu).
#pragma once

#include <cstdint>

#include "mapper/align/normal_equations.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/align/surface_cell.hpp"

namespace g3d::mapper::align {

struct FitQuestion {
  hal::Pose predicted;  ///< T_world_camera, by odometry
  Matrix6 prior{};      ///< information of that
  double data_weight = 0.0;
  double least_matched = 0.0;  ///< of the chosen samples
  std::int64_t born_by_ns = 0;
  float kernel_m = 0.0F;
  std::int32_t most_steps = 0;
};
struct FitAnswer {
  hal::Pose pose;
  NormalSums first;  ///< at the predicted pose
  NormalSums last;   ///< at `pose`
};

// Samples are weighted relative to a sigma of 1 mm.
inline constexpr double kUnitInformation = 1e6;

/// What the sums are to be multiplied with.
[[nodiscard]] inline double information_unit(const NormalSums& sums, double data_weight) {
  // A mean square below this says how well the samples fit, not how well they are known.
  constexpr double kLeastMeanSquare = 0.05;
  const double square = sums.mean_square() * kUnitInformation;
  return data_weight * kUnitInformation / (square < kLeastMeanSquare ? kLeastMeanSquare : square);
}
[[nodiscard]] inline bool has_enough(const NormalSums& sums, double chosen, const FitQuestion& question) {
  return static_cast<double>(sums.matched) / chosen >= question.least_matched;
}

/// `T`: the pose that it is matched at. `look_up` as for nearest_piece().
template <typename LookUp>
inline void add_match(const DepthSample& sample, const hal::RigidTransform& T, const SurfaceRule& rule, float kernel_m,
                      std::int64_t born_by_ns, const LookUp& look_up, NormalSums& sums) {
  // Surfaces that face more than 37 degrees apart are not the same one.
  constexpr float kLeastCosineOfNormals = 0.8F;
  const Vector3f arm = rotated(T, sample.point_m);
  const Vector3f n = rotated(T, sample.normal);
  const Vector3f at{arm[0] + T.translation_m[0], arm[1] + T.translation_m[1], arm[2] + T.translation_m[2]};
  SurfacePiece piece;
  if (!nearest_piece(rule, at, n, born_by_ns, look_up, piece) || dot(piece.normal, n) < kLeastCosineOfNormals) return;
  const Vector3f& f = piece.normal;
  const float r = dot(f, {at[0] - piece.point_m[0], at[1] - piece.point_m[1], at[2] - piece.point_m[2]});
  const float ceiling = kernel_m * kernel_m;
  const float share = ceiling / (ceiling + r * r);
  sums.add(
      {f[0], f[1], f[2], arm[1] * f[2] - arm[2] * f[1], arm[2] * f[0] - arm[0] * f[2], arm[0] * f[1] - arm[1] * f[0]},
      r, sample.weight * share * share);
  sums.add_cost(sample.weight * r * r * share);
}

/// Moves the pose by what the sums at it ask for. False: there is nothing (more) to be done.
[[nodiscard]] inline bool take_step(const NormalSums& sums, double chosen, const FitQuestion& question, int step,
                                    hal::Pose& pose) {
  constexpr double kConverged_m = 1e-4;
  constexpr double kConverged_rad = 5e-5;
  if (!has_enough(sums, chosen, question) || step == question.most_steps) return false;
  const double unit = information_unit(sums, question.data_weight);
  const Vector6 gradient = sums.gradient_vector();
  const Vector6 off = difference(pose, question.predicted);
  Matrix6 a = sums.matrix();
  Vector6 b{};
#pragma GCC unroll 6
  for (std::size_t i = 0; i < 6; ++i) {
    b[i] = -unit * gradient[i];
#pragma GCC unroll 6
    for (std::size_t j = 0; j < 6; ++j) {
      a[6 * i + j] = a[6 * i + j] * unit + question.prior[6 * i + j];
      b[i] += question.prior[6 * i + j] * off[j];
    }
  }
  Vector6 x{};
  if (!solve(a, b, x) || (shift_of(x) < kConverged_m && turn_of(x) < kConverged_rad)) return false;
  pose = moved(pose, x);
  return true;
}

}  // namespace g3d::mapper::align
