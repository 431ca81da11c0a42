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

constexpr std::uint32_t kLeastSamples = 100;
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

Aligner::Aligner(const AlignOptions& options, const hal::CameraModel& camera, FitCard* card)
    : options_(options), samples_(camera, options.samples), card_(card), surfaces_(options.surface) {}

FitQuestion Aligner::question_of(const hal::Pose& predicted, const Matrix6& prior) const {
  return {predicted,          prior, options_.data_weight, options_.least_matched, born_by_ns_, options_.kernel_m,
          options_.most_steps};
}

void Aligner::sample_and_fit(const hal::Frame& frame, const FitQuestion& question) {
  const std::size_t forgotten = surfaces_.make_room();
  report_.forgotten_pieces += forgotten;
  if (forgotten > 0 && card_ != nullptr) card_->forget_surfaces();
  is_on_card_ = card_ != nullptr && card_->fit(frame, samples_.shape(), surfaces_, question, fitted_);
  if (is_on_card_) return;
  samples_.compute(frame.depth.get());
  fitted_.chosen = static_cast<std::uint32_t>(samples_.chosen().size());
  if (fitted_.chosen >= kLeastSamples) fitted_.answer = fit(samples_.chosen(), surfaces_, question);
}

void Aligner::add_samples(const hal::Frame& frame, const hal::Pose& T_world_camera, const SeenSpace* space) {
  const hal::RigidTransform T = hal::to_transform(T_world_camera);
  if (is_on_card_ && card_->add(T, frame.stamp_ns, space != nullptr, surfaces_)) return;
  if (is_on_card_) samples_.compute(frame.depth.get());
  surfaces_.add(samples_.all(), T, frame.stamp_ns, space);
  if (space != nullptr) surfaces_.forget_gone(*space);
}

AlignResult Aligner::judge(const FitQuestion& question, const Matrix6& model, double most_surprise,
                           Matrix6& information) const {
  AlignResult result;
  const hal::Pose& predicted = question.predicted;
  result.T_world_camera = predicted;
  if (fitted_.chosen < kLeastSamples) {
    result.outcome = AlignOutcome::few_samples;
    return result;
  }
  const auto chosen = static_cast<double>(fitted_.chosen);
  const FitAnswer& fitted = fitted_.answer;
  result.matched = static_cast<double>(fitted.last.matched) / chosen;
  if (!has_enough(fitted.last, chosen, question)) {
    result.outcome = AlignOutcome::little_overlap;
    return result;
  }
  result.outcome = AlignOutcome::aligned;
  const Vector6 correction = difference(predicted, fitted.pose);
  result.residual_m = std::sqrt(fitted.last.mean_square());
  // A mount that was measured wrongly tilts the camera, which is no fault of the wheels.
  const bool on_floor = options_.motion == Motion::planar;
  const Vector6 of_wheels{correction[0], correction[1], 0.0, 0.0, 0.0, correction[5]};
  result.surprise = std::sqrt(quadratic(model, on_floor ? of_wheels : correction));
  if (shift_of(correction) > kMostShift_m || turn_of(correction) > kMostTurn_rad || result.surprise > most_surprise) {
    result.outcome = AlignOutcome::implausible;
  } else if (fitted.last.mean_cost() > kNoBetter * fitted.first.mean_cost() ||
             static_cast<double>(fitted.last.matched) < kFewer * static_cast<double>(fitted.first.matched)) {
    result.outcome = AlignOutcome::no_better;
  } else {
    result.T_world_camera = fitted.pose;
    result.correction = correction;
    information = fitted.last.matrix();
    for (double& x : information) x *= information_unit(fitted.last, options_.data_weight);
    const Matrix6 odometry = without_floor(model, options_.motion);
    result.holds_shift = is_held(information, odometry, 0);
    result.holds_turn = is_held(information, odometry, 3);
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
  const bool is_measured = options_.source == OdometrySource::measured;
  const bool learns = is_measured && options_.motion == Motion::planar;
  const bool learns_trust = learns && options_.learns_trust;
  const bool is_robot = space != nullptr && learns;
  AlignResult result;
  if (!last_odometry_) {
    result.T_world_camera = T_odometry_camera;
    first_stamp_ns_ = frame.stamp_ns;
    sample_and_fit(frame, question_of(T_odometry_camera, {}));  // there is nothing to fit to yet
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
    const auto prior_of = [&](const OdometryNoise& noise) {
      return prior_information(noise, options_.motion, options_.source, since_aligned_m_, since_aligned_s_);
    };
    const Matrix6 model = prior_of(options_.noise);
    const FitQuestion question = question_of(predicted, learns_trust ? prior_of(trust_.scaled(options_.noise)) : model);
    sample_and_fit(frame, question);
    Matrix6 information{};
    result = judge(question, model, is_robot ? options_.most_surprise : std::numeric_limits<double>::infinity(),
                   information);
    if (result.outcome == AlignOutcome::aligned && learns_trust) {
      trust_.learn(result.correction, information, question.prior, model, since_aligned_s_);
    }
  }
  if (result.outcome == AlignOutcome::aligned && learns) {
    habits_.learn(result.correction, since_aligned_m_, since_aligned_s_, result.holds_shift, result.holds_turn);
  }
  // Hand-held, more doubt after refused frames made the worst of fr1_rpy better and its median worse.
  if (result.outcome == AlignOutcome::aligned || !is_robot) {
    since_aligned_s_ = 0.0;
    since_aligned_m_ = {};
  }
  report_.count(result.outcome, result.correction, result.holds_shift, result.holds_turn);
  add_samples(frame, result.T_world_camera, space);
  report_.surface_pieces = surfaces_.piece_count();
  report_.refused_samples = surfaces_.refused();
  report_.learnt_turn_radps = habits_.turn_radps();
  report_.learnt_stretch = habits_.stretch();
  if (learns_trust) report_.turn_noise_scale = trust_.turn_scale();
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
