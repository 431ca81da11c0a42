// SPDX-License-Identifier: Apache-2.0
// Corrects odometry frame by frame: each depth image is aligned to the surfaces that earlier ones have shown, starting
// from odometry and with odometry as a Gaussian prior in every solve. What the scene does not fix stays as odometry has
// it: along a corridor, in front of a wall. A result that is no better than odometry by its own residuals, or not
// believable, is not taken, and counted by reason.
// Where odometry itself is wrong (wheels that spin, a robot that is pushed) its prior holds the pose near it: to
// believe the scene instead was tried, and followed people who filled the view. Thread: one. Nothing is allocated after
// construction. The same frames and poses give the same bits everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "hal/messages.hpp"
#include "mapper/align/align_report.hpp"
#include "mapper/align/depth_samples.hpp"
#include "mapper/align/fit_card.hpp"
#include "mapper/align/motion_prior.hpp"
#include "mapper/align/odometry_habits.hpp"
#include "mapper/align/odometry_trust.hpp"
#include "mapper/align/surface_map.hpp"

namespace g3d::mapper::align {

struct AlignOptions {
  Motion motion = Motion::planar;
  OdometrySource source = OdometrySource::measured;
  OdometryNoise noise;
  SampleOptions samples;
  SurfaceOptions surface;
  /// Neighbouring samples err alike, so that each of thousands counts for little. Over the mean square of the
  /// residuals, in units of the sensor's noise: a scene that contradicts itself says less.
  double data_weight = 0.2;
  float kernel_m = 0.04F;                  ///< Geman-McClure: a residual of this size counts a quarter
  int most_steps = 8;                      ///< of Gauss-Newton
  hal::TimeNs least_age_ns = 200'000'000;  ///< planar: surfaces younger than this may be somebody who walks
  double least_matched = 0.4;              ///< of the chosen samples
  /// Planar, with a map: a robot's odometry is no farther off than so many of its standard deviations. What asks for
  /// more is taken for somebody who moves, most of whom was there before; a robot that is pushed is not helped then.
  double most_surprise = 4.0;
  /// Planar, measured: how well odometry knows its turns is learnt, see OdometryTrust. False: `noise` says it.
  bool learns_trust = true;
};

struct AlignResult {
  AlignOutcome outcome = AlignOutcome::first;
  hal::Pose T_world_camera;  ///< corrected, or odometry's step from the last one
  Vector6 correction{};      ///< by how much odometry's step was corrected, world axes
  double matched = 0.0;      ///< fraction of the chosen samples
  double residual_m = 0.0;   ///< root mean square, weighted
  double surprise = 0.0;     ///< how many of odometry's standard deviations the correction is
  bool holds_shift = false;  ///< in some direction odometry says more than the scene does
  bool holds_turn = false;
  /// Some of the step, or all of it, is odometry's word alone.
  [[nodiscard]] bool is_held() const { return !is_corrected(outcome) || holds_shift || holds_turn; }
};

class Aligner {
 public:
  /// `card`: fits frames instead of the CPU while it can; outlives this.
  Aligner(const AlignOptions& options, const hal::CameraModel& camera, FitCard* card = nullptr);

  /// `T_odometry_camera`: the camera in odometry's own frame, which may drift. Stamps ascend. `space`: the map of all
  /// frames before this one, if the caller may look at it; then nothing that moves is aligned to.
  AlignResult align(const hal::Frame& frame, const hal::Pose& T_odometry_camera, const SeenSpace* space = nullptr);

  /// The map was corrected after the last frame: by `T_newest` where the camera is now, by `correction_at(time)` where
  /// something was first seen at that time. Allocates.
  void correct(const hal::Pose& T_newest, const std::function<hal::Pose(hal::TimeNs)>& correction_at);

  [[nodiscard]] const AlignOptions& options() const { return options_; }
  [[nodiscard]] const SurfaceMap& surfaces() const { return surfaces_; }
  [[nodiscard]] const OdometryHabits& habits() const { return habits_; }
  [[nodiscard]] const OdometryTrust& trust() const { return trust_; }
  [[nodiscard]] bool has_card() const { return card_ != nullptr; }
  /// Of the last frame, camera frame. Not if a card has them.
  [[nodiscard]] std::span<const DepthSample> samples() const { return samples_.all(); }
  /// After the last frame, or from the thread that aligns.
  [[nodiscard]] const AlignReport& report() const { return report_; }

 private:
  [[nodiscard]] FitQuestion question_of(const hal::Pose& predicted, const Matrix6& prior) const;
  /// By the card, or by the CPU if there is none any more.
  void sample_and_fit(const hal::Frame& frame, const FitQuestion& question);
  void add_samples(const hal::Frame& frame, const hal::Pose& T_world_camera, const SeenSpace* space);
  /// `model`: the prior by what odometry's noise is stated to be. `information`: what the image says, if it is
  /// believed.
  [[nodiscard]] AlignResult judge(const FitQuestion& question, const Matrix6& model, double most_surprise,
                                  Matrix6& information) const;

  AlignOptions options_;
  DepthSamples samples_;
  FitCard* card_;
  bool is_on_card_ = false;  ///< the frame in hand
  CardFit fitted_;
  SurfaceMap surfaces_;
  std::optional<hal::Pose> last_odometry_;
  hal::Pose last_pose_;
  hal::TimeNs last_stamp_ns_ = 0;
  double since_aligned_s_ = 0.0;  ///< while a robot's frames are refused, odometry's errors add up
  std::array<double, 3> since_aligned_m_{};
  OdometryHabits habits_;  ///< planar, measured
  OdometryTrust trust_;    ///< as well
  hal::TimeNs first_stamp_ns_ = 0;
  hal::TimeNs born_by_ns_ = 0;  ///< what this frame may be aligned to
  AlignReport report_;
};

}  // namespace g3d::mapper::align
