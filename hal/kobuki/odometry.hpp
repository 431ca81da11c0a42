// SPDX-License-Identifier: Apache-2.0
// Where the base is, from its wheels and its gyro: the way from the encoders, the heading from the gyro (its angle
// cannot be reset, so the first reading is the offset). While the wheels stand, so does the heading: what the gyro says
// then is its drift, which is subtracted while they turn; but for the last moment before a tick, which is the turn that
// the tick belongs to.
#pragma once

#include <optional>

#include "hal/kobuki/feedback.hpp"
#include "hal/twist.hpp"

namespace g3d::hal::kobuki {

/// How far the base's stamps may run away from our clock in one step: bytes wait in buffers, clocks differ a little.
inline constexpr int kStampSlack_ms = 250;

enum class Wheel : std::uint8_t { none, left, right };

/// What did and what did not move the pose, counted.
struct OdometryCounts {
  std::uint64_t steps = 0;
  std::uint64_t duplicates = 0;    ///< same stamp as before
  std::uint64_t restarts = 0;      ///< another session of the base: a new reference
  std::uint64_t gaps = 0;          ///< more than 200 ms without a packet, in which the base went on
  std::uint64_t out_of_gates = 0;  ///< further than a base can get in that time: a new reference
};

/// One thread. Allocates nothing.
class Odometry {
 public:
  explicit Odometry(const PlanarPose& T_world_base = {}) : T_world_base_(T_world_base) {}
  /// Packets in the order they came. The first is the reference. After a gap in which the base went on, the way is
  /// taken for one arc; more than 2 m are not believed, whatever the gap.
  void update(const Feedback& feedback);
  [[nodiscard]] const PlanarPose& T_world_base() const { return T_world_base_; }
  /// Over the last step; zero once the base's stamps have stood still for 100 ms.
  [[nodiscard]] const Twist& velocity() const { return velocity_; }
  /// Sum of |way| of the base's centre and of |turns|.
  [[nodiscard]] double path_m() const { return path_m_; }
  [[nodiscard]] double rotation_rad() const { return rotation_rad_; }
  /// A wheel is driven and does not tick, while the other does and the gyro says that the base does not turn about the
  /// silent one: its encoder, or the cable, is dead. Reported after 0.5 s, until it ticks again.
  [[nodiscard]] bool wheel_is_dead() const { return dead_wheel_ != Wheel::none; }
  [[nodiscard]] Wheel dead_wheel() const { return dead_wheel_; }
  /// Both wheels are driven and neither has ticked for 0.5 s, or for 0.2 s after they rolled: the base pushes against
  /// something, or neither encoder counts.
  [[nodiscard]] bool is_stalled() const {
    return stalled_ms_ >= (rolled_before_ ? kPatienceAfterRolling_ms : kPatience_ms);
  }
  /// Both wheels have ticked in the last step.
  [[nodiscard]] bool are_both_rolling() const { return both_ticked_; }
  /// What the gyro turns by itself, as seen at rest; 0 until the base has rested for 5 s in all and there is
  /// more than rounding.
  [[nodiscard]] double gyro_drift_cdegps() const;
  [[nodiscard]] const OdometryCounts& counts() const { return counts_; }

 private:
  static constexpr int kPatience_ms = 500;
  // From rest it may take its time until a wheel turns; no base stops from one packet to the next and stays driven.
  static constexpr int kPatienceAfterRolling_ms = 200;
  struct Step {
    int elapsed_ms = 0;
    int left_ticks = 0, right_ticks = 0;
    int turn_cdeg = 0;
  };
  struct Turned {
    int cdeg = 0;
    int ms = 0;
    void add(const Turned& more) {
      cdeg += more.cdeg;
      ms += more.ms;
    }
  };
  struct Suspicion {
    int silent_ms = 0;  // driven without a tick
    int other_ticks = 0;
    int turn_cdeg = 0;
  };
  [[nodiscard]] std::optional<Step> step_from_last(const Feedback& feedback);
  [[nodiscard]] double true_turn_cdeg(const Step& step);
  void move(const Step& step);
  void watch_wheels(const Step& step, const Feedback& feedback);
  void watch_wheel(Suspicion& suspicion, Wheel wheel, int ticks, int other_ticks, int pwm, const Step& step);

  PlanarPose T_world_base_;
  Twist velocity_;
  double path_m_ = 0.0, rotation_rad_ = 0.0;
  std::optional<Feedback> last_;
  TimeNs moved_ns_ = 0;  // when a new stamp came last
  int at_rest_ms_ = 0;
  Turned drift_;                      // what the gyro said at rest
  Turned rest_before_, rest_newest_;  // ... and just now: it may be the beginning of a turn
  int stalled_ms_ = 0;
  bool both_ticked_ = false;
  bool rolled_before_ = false;  // at 0.1 m/s or more, in the step before the wheels stopped
  Suspicion left_, right_;
  Wheel dead_wheel_ = Wheel::none;
  OdometryCounts counts_;
};

}  // namespace g3d::hal::kobuki
