// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/odometry.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "hal/kobuki/packet_gates.hpp"
#include "hal/sim/plain_trig.hpp"

namespace g3d::hal::kobuki {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadPerCdeg = kPi / 18'000.0;
constexpr TimeNs kStale_ns = 100'000'000;
constexpr int kStampWrap_ms = 65'536;
constexpr int kLongestGap_ms = 2'000;
/// After this long without a tick the base rests, and has stopped swaying; a gyro drifts by less than this much.
constexpr int kRest_ms = 1'000;
constexpr int kDrift_cdegps = 100;
/// A turn has begun before a wheel has ticked: a tick of one wheel is two hundredths of a degree. What the gyro says so
/// shortly before a tick is no drift.
constexpr int kBeforeTick_ms = 300;
/// So much rest, and so many hundredths of a degree in it, are no rounding.
constexpr int kDriftKnown_ms = 5'000;
constexpr int kDriftKnown_cdeg = 5;
constexpr int kDriftMemory_ms = 60'000;
/// A driven wheel has at least this much PWM; captured bases roll at 13.
constexpr int kDriven_pwm = 8;
constexpr double kRolling_mps = 0.1;
/// The other wheel's way that makes a silent one suspicious: 17 mm.
constexpr int kSuspicious_ticks = 200;

double wrapped(double angle_rad) {
  if (angle_rad > kPi) return angle_rad - 2.0 * kPi;
  if (angle_rad <= -kPi) return angle_rad + 2.0 * kPi;
  return angle_rad;
}

}  // namespace

void Odometry::update(const Feedback& feedback) {
  if (last_ && feedback.timestamp_ms == last_->timestamp_ms &&
      feedback.received_ns - last_->received_ns < kStampWrap_ms / 2 * kMillisecond_ns) {
    ++counts_.duplicates;
    if (feedback.received_ns - moved_ns_ > kStale_ns) velocity_ = {};
    return;
  }
  if (const std::optional<Step> step = step_from_last(feedback)) {
    move(*step);
    watch_wheels(*step, feedback);
    ++counts_.steps;
  } else {
    velocity_ = {};
  }
  moved_ns_ = feedback.received_ns;
  last_ = feedback;
}

std::optional<Odometry::Step> Odometry::step_from_last(const Feedback& feedback) {
  if (!last_) return std::nullopt;
  Step step{ms_between(*last_, feedback), ticks_between(last_->left_encoder_ticks, feedback.left_encoder_ticks),
            ticks_between(last_->right_encoder_ticks, feedback.right_encoder_ticks),
            angle_between_cdeg(last_->gyro_angle_cdeg, feedback.gyro_angle_cdeg)};
  const std::int64_t waited_ms = (feedback.received_ns - last_->received_ns) / kMillisecond_ns;
  if (step.elapsed_ms > kMaxTimeStep_ms) {
    // A gap, or one packet with a wrong stamp, whose undoing looks like a step back; else the base began anew.
    const bool went_on = std::abs(waited_ms - step.elapsed_ms) <= kStampSlack_ms;
    const bool went_back = step.elapsed_ms >= kStampWrap_ms - kMaxTimeStep_ms && waited_ms <= kStampSlack_ms;
    if (!went_on && !went_back) {
      ++counts_.restarts;
      return std::nullopt;
    }
    ++counts_.gaps;
    if (went_back) step.elapsed_ms = static_cast<int>(std::max<std::int64_t>(waited_ms, 20));
  }
  // Encoders wrap within 2.7 s of full speed: after longer gaps only a short way can be told from a wrapped one.
  const int max_ticks = max_ticks_in(std::min(step.elapsed_ms, kLongestGap_ms));
  if (std::abs(step.left_ticks) > max_ticks || std::abs(step.right_ticks) > max_ticks ||
      std::abs(step.turn_cdeg) > max_angle_in_cdeg(step.elapsed_ms)) {
    ++counts_.out_of_gates;
    return std::nullopt;
  }
  return step;
}

double Odometry::gyro_drift_cdegps() const {
  if (drift_.ms < kDriftKnown_ms || std::abs(drift_.cdeg) < kDriftKnown_cdeg) return 0.0;
  return 1000.0 * drift_.cdeg / drift_.ms;
}

double Odometry::true_turn_cdeg(const Step& step) {
  const bool stands = step.left_ticks == 0 && step.right_ticks == 0;
  at_rest_ms_ = stands ? std::min(at_rest_ms_ + step.elapsed_ms, kRest_ms) : 0;
  const bool may_be_drift = std::abs(step.turn_cdeg) <= 1 + kDrift_cdegps * step.elapsed_ms / 1000;
  if (at_rest_ms_ >= kRest_ms && may_be_drift) {
    rest_newest_.add({step.turn_cdeg, step.elapsed_ms});
    if (rest_newest_.ms < kBeforeTick_ms) return 0.0;
    drift_.add(rest_before_);
    if (drift_.ms > kDriftMemory_ms) drift_ = {drift_.cdeg / 2, drift_.ms / 2};
    rest_before_ = std::exchange(rest_newest_, {});
    return 0.0;
  }
  Turned turned{step.turn_cdeg, step.elapsed_ms};
  turned.add(std::exchange(rest_before_, {}));
  turned.add(std::exchange(rest_newest_, {}));
  return turned.cdeg - gyro_drift_cdegps() * turned.ms / 1000.0;
}

void Odometry::move(const Step& step) {
  const double way_m = 0.5 * (step.left_ticks + step.right_ticks) * kMetresPerTick;
  const double turn_rad = true_turn_cdeg(step) * kRadPerCdeg;
  // The chord of an arc lies along the heading half-way and is shorter by turn^2 / 24: 1e-4 of it in 20 ms.
  const double chord_m = way_m * (1.0 - turn_rad * turn_rad / 24.0);
  const SinCos along = sin_cos_deg((T_world_base_.heading_rad + 0.5 * turn_rad) * (180.0 / kPi));
  T_world_base_.x_m += chord_m * along.cos;
  T_world_base_.y_m += chord_m * along.sin;
  T_world_base_.heading_rad = wrapped(T_world_base_.heading_rad + turn_rad);
  velocity_ = {1000.0 * way_m / step.elapsed_ms, 1000.0 * turn_rad / step.elapsed_ms};
  path_m_ += std::abs(way_m);
  rotation_rad_ += std::abs(turn_rad);
}

void Odometry::watch_wheels(const Step& step, const Feedback& feedback) {
  watch_wheel(left_, Wheel::left, step.left_ticks, step.right_ticks, feedback.left_pwm, step);
  watch_wheel(right_, Wheel::right, step.right_ticks, step.left_ticks, feedback.right_pwm, step);
  both_ticked_ = step.left_ticks != 0 && step.right_ticks != 0;
  const bool is_pushing = std::abs(int{feedback.left_pwm}) >= kDriven_pwm &&
                          std::abs(int{feedback.right_pwm}) >= kDriven_pwm && step.left_ticks == 0 &&
                          step.right_ticks == 0;
  stalled_ms_ = is_pushing ? std::min(stalled_ms_ + step.elapsed_ms, kPatience_ms) : 0;
  if (stalled_ms_ > 0) return;
  const int ticks = std::max(std::abs(step.left_ticks), std::abs(step.right_ticks));
  rolled_before_ = ticks * kMetresPerTick * 1000.0 >= kRolling_mps * step.elapsed_ms;
}

void Odometry::watch_wheel(Suspicion& suspicion, Wheel wheel, int ticks, int other_ticks, int pwm, const Step& step) {
  if (ticks != 0) {
    suspicion = {};
    if (dead_wheel_ == wheel) dead_wheel_ = Wheel::none;
    return;
  }
  if (std::abs(pwm) < kDriven_pwm) return;
  suspicion.silent_ms = std::min(suspicion.silent_ms + step.elapsed_ms, kPatience_ms);
  suspicion.other_ticks += other_ticks;
  suspicion.turn_cdeg += step.turn_cdeg;
  if (suspicion.silent_ms < kPatience_ms || std::abs(suspicion.other_ticks) < kSuspicious_ticks) return;
  // If the silent wheel stood, the other one turned the base about it by this much.
  const double way_m = suspicion.other_ticks * kMetresPerTick;
  const double expected_cdeg = (wheel == Wheel::left ? way_m : -way_m) / kWheelBase_m / kRadPerCdeg;
  const bool turned_about_it = std::abs(suspicion.turn_cdeg - expected_cdeg) < 0.5 * std::abs(expected_cdeg);
  if (!turned_about_it) dead_wheel_ = wheel;
  suspicion = {};  // it may also really stand: blocked, or held by its motor
}

}  // namespace g3d::hal::kobuki
