// SPDX-License-Identifier: Apache-2.0
#include "mapper/align/aligner.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>
#include <limits>

#include "mapper/align/point_to_plane.hpp"
#include "mapper/align/pose_step.hpp"

namespace g3d::mapper::align {
namespace {

constexpr std::size_t kLeastSamples = 100;
constexpr double kConverged_m = 1e-4;
constexpr double kConverged_rad = 5e-5;
// Samples are weighted relative to a sigma of 1 mm.
constexpr double kUnitInformation = 1e6;
// A mean square below this says how well the samples fit, not how well they are known.
constexpr double kLeastMeanSquare = 0.05;
// Samples find and lose their surfaces on the way, so that equal fits may differ by a little.
constexpr double kNoBetter = 1.05;
constexpr double kFewer = 0.9;
// Between two frames no robot is pushed farther, and the search would not find it.
constexpr double kMostShift_m = 0.35;
constexpr double kMostTurn_rad = 0.35;
constexpr double kFarthest_m = 30'000.0;

/// Whether the scene says less than odometry in some direction of one 3x3 part of the information.
bool is_held(const Matrix6& data, const Matrix6& prior, std::size_t part) {
  Eigen::Matrix3d d;
  Eigen::Matrix3d p;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      d(static_cast<int>(a), static_cast<int>(b)) = data[6 * (part + a) + part + b];
      p(static_cast<int>(a), static_cast<int>(b)) = prior[6 * (part + a) + part + b];
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>((d - p).eval(), Eigen::EigenvaluesOnly).eigenvalues()[0] < 0.0;
}

/// In a plane, height and tilt are odometry's by right and not for want of a view.
Matrix6 without_floor(const Matrix6& prior, Motion motion) {
  Matrix6 freed = prior;
  if (motion == Motion::planar) freed[7 * 2] = freed[7 * 3] = freed[7 * 4] = -1e18;
  return freed;
}

/// Such a pose is a mistake, which no map takes; were it followed there, the digits of the way back would be lost.
bool is_beyond(const hal::Pose& T) {
  return std::any_of(T.translation_m.begin(), T.translation_m.end(),
                     [](double t_m) { return !(std::abs(t_m) < kFarthest_m); });
}

}  // namespace

Aligner::Aligner(const AlignOptions& options, const hal::CameraModel& camera)
    : options_(options), samples_(camera, options.samples), surfaces_(options.surface) {}

Aligner::Solution Aligner::solve_from(const hal::Pose& predicted, const Matrix6& prior) const {
  Solution s;
  s.pose = predicted;
  const auto chosen = static_cast<double>(samples_.chosen().size());
  for (int step = 0;; ++step) {
    const NormalSums sums = match(samples_.chosen(), surfaces_, s.pose, options_.kernel_m, born_by_ns_);
    s.matched = static_cast<double>(sums.matched) / chosen;
    s.cost = sums.mean_cost();
    s.mean_square = sums.mean_square();
    s.enough = s.matched >= options_.least_matched;
    const double unit =
        options_.data_weight * kUnitInformation / std::max(kLeastMeanSquare, s.mean_square * kUnitInformation);
    s.information = sums.matrix();
    for (double& x : s.information) x *= unit;
    if (!s.enough || step == options_.most_steps) return s;

    const Vector6 gradient = sums.gradient_vector();
    const Vector6 off = difference(s.pose, predicted);
    Matrix6 a = s.information;
    Vector6 b{};
    for (std::size_t i = 0; i < 6; ++i) {
      b[i] = -unit * gradient[i];
      for (std::size_t j = 0; j < 6; ++j) {
        a[6 * i + j] += prior[6 * i + j];
        b[i] += prior[6 * i + j] * off[j];
      }
    }
    Vector6 x{};
    if (!solve(a, b, x)) return s;
    if (shift_of(x) < kConverged_m && turn_of(x) < kConverged_rad) return s;
    s.pose = moved(s.pose, x);
  }
}

AlignResult Aligner::judge(const hal::Pose& predicted, const Matrix6& prior, double most_surprise) const {
  AlignResult result;
  result.T_world_camera = predicted;
  const auto chosen = static_cast<double>(samples_.chosen().size());
  if (samples_.chosen().size() < kLeastSamples) {
    result.outcome = AlignOutcome::few_samples;
    return result;
  }
  const Solution s = solve_from(predicted, prior);
  result.matched = s.matched;
  if (!s.enough) {
    result.outcome = AlignOutcome::little_overlap;
    return result;
  }
  result.outcome = AlignOutcome::aligned;
  const Vector6 correction = difference(predicted, s.pose);
  result.matched = s.matched;
  result.residual_m = std::sqrt(s.mean_square);
  // A mount that was measured wrongly tilts the camera, which is no fault of the wheels.
  const bool on_floor = options_.motion == Motion::planar;
  const Vector6 of_wheels{correction[0], correction[1], 0.0, 0.0, 0.0, correction[5]};
  result.surprise = std::sqrt(quadratic(prior, on_floor ? of_wheels : correction));
  if (shift_of(correction) > kMostShift_m || turn_of(correction) > kMostTurn_rad || result.surprise > most_surprise) {
    result.outcome = AlignOutcome::implausible;
  } else if (const NormalSums there = match(samples_.chosen(), surfaces_, predicted, options_.kernel_m, born_by_ns_);
             s.cost > kNoBetter * there.mean_cost() ||
             s.matched * chosen < kFewer * static_cast<double>(there.matched)) {
    result.outcome = AlignOutcome::no_better;
  } else {
    result.T_world_camera = s.pose;
    result.correction = correction;
    const Matrix6 odometry = without_floor(prior, options_.motion);
    result.holds_shift = is_held(s.information, odometry, 0);
    result.holds_turn = is_held(s.information, odometry, 3);
  }
  return result;
}

AlignResult Aligner::align(const hal::Frame& frame, const hal::Pose& T_odometry_camera, const SeenSpace* space) {
  if (is_beyond(T_odometry_camera)) {
    AlignResult nowhere;
    nowhere.outcome = AlignOutcome::implausible;
    nowhere.T_world_camera = T_odometry_camera;
    report_.count(nowhere.outcome, {}, false, false);
    return nowhere;
  }
  samples_.compute(frame.depth.get());
  const bool is_measured = options_.source == OdometrySource::measured;
  const bool is_robot = space != nullptr && is_measured && options_.motion == Motion::planar;
  AlignResult result;
  if (!last_odometry_) {
    result.T_world_camera = T_odometry_camera;
    first_stamp_ns_ = frame.stamp_ns;
  } else {
    const hal::Pose step = is_measured ? hal::compose(hal::inverse(*last_odometry_), T_odometry_camera) : hal::Pose{};
    const double dt_s = std::max(1e-3, static_cast<double>(frame.stamp_ns - last_stamp_ns_) / 1e9);
    const hal::Pose predicted = habits_.predicted(last_pose_, step, dt_s);
    for (std::size_t i = 0; i < 3; ++i) {
      since_aligned_m_[i] += predicted.translation_m[i] - last_pose_.translation_m[i];
    }
    // At the very start everything is young.
    const hal::TimeNs age_ns = options_.motion == Motion::planar ? options_.least_age_ns : 0;
    const hal::TimeNs old_ns = frame.stamp_ns - age_ns;
    born_by_ns_ = old_ns < first_stamp_ns_ ? first_stamp_ns_ : old_ns;
    since_aligned_s_ += dt_s;
    result =
        judge(predicted,
              prior_information(options_.noise, options_.motion, options_.source, since_aligned_m_, since_aligned_s_),
              is_robot ? options_.most_surprise : std::numeric_limits<double>::infinity());
  }
  if (result.outcome == AlignOutcome::aligned && is_measured && options_.motion == Motion::planar) {
    habits_.learn(result.correction, since_aligned_m_, since_aligned_s_, result.holds_shift, result.holds_turn);
  }
  // Hand-held, more doubt after refused frames made the worst of fr1_rpy better and its median worse.
  if (result.outcome == AlignOutcome::aligned || !is_robot) {
    since_aligned_s_ = 0.0;
    since_aligned_m_ = {};
  }
  report_.count(result.outcome, result.correction, result.holds_shift, result.holds_turn);
  surfaces_.add(samples_.all(), hal::to_transform(result.T_world_camera), frame.stamp_ns, space);
  if (space != nullptr) surfaces_.forget_gone(*space);
  report_.surface_pieces = surfaces_.piece_count();
  report_.refused_samples = surfaces_.refused();
  last_odometry_ = T_odometry_camera;
  last_pose_ = result.T_world_camera;
  last_stamp_ns_ = frame.stamp_ns;
  return result;
}

void Aligner::correct(const hal::Pose& T_newest, const std::function<hal::Pose(hal::TimeNs)>& correction_at) {
  last_pose_ = hal::compose(T_newest, last_pose_);
  surfaces_.move(correction_at);
}

}  // namespace g3d::mapper::align
