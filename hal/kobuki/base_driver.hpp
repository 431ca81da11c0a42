// SPDX-License-Identifier: Apache-2.0
// The Kobuki, step by step: bytes in, bytes out. It has no thread, clock or line of its own, so that a simulation in
// lockstep and the thread at the real line (base_thread.hpp) run the very same code:
//
//   bytes -> PacketReader -> Odometry -> latches -> table -> SpeedLimits -> table again -> bytes
//
// The table has the last word. Each 20 ms a command goes out, whether feedback arrives or not; zero speed goes out at
// once when what was sent last is no longer allowed.
#pragma once

#include <span>

#include "hal/kobuki/base_state.hpp"
#include "hal/kobuki/link_delay.hpp"
#include "hal/kobuki/odometry.hpp"
#include "hal/kobuki/outputs.hpp"
#include "hal/kobuki/packet_reader.hpp"
#include "hal/kobuki/pose_history.hpp"
#include "hal/kobuki/retreat_trail.hpp"
#include "hal/kobuki/signals.hpp"
#include "hal/kobuki/speed_limits.hpp"
#include "hal/safety_latches.hpp"

namespace g3d::hal::kobuki {

struct BaseDriverOptions {
  SafetyTimes times;
  SpeedLimitOptions limits;
  BatteryOptions battery;
  TimeNs period_ns = kPacketPeriod_ns;
  TimeNs rear_free_ns = 500'000'000;  ///< how long set_rear_free holds
  bool sounds = true;
};

/// One thread. Allocates nothing. All stamps are of the same clock.
class BaseDriver {
 public:
  explicit BaseDriver(const BaseDriverOptions& options = {});

  /// What the line gave, at `received_ns`. Call tick() right after: it sends zeros at once if these bytes demand it.
  void on_bytes(std::span<const std::uint8_t> bytes, TimeNs received_ns);
  /// The line was lost: what follows comes from a base that must prove itself again.
  void on_line_lost();

  /// The velocity that is wanted, decided at `stamp_ns`. Holds until the next one, or until it is stale.
  void set_command(const Twist& wanted, TimeNs stamp_ns);
  /// An image was taken at `stamp_ns`. Only good ones count: not the same one twice, not black ones.
  void set_camera_alive(TimeNs stamp_ns);
  /// Somebody knows that the floor behind the base is free. Where the base came from it knows that itself.
  void set_rear_free(TimeNs stamp_ns);
  void set_e_stop(bool pressed);
  /// Whether a stop device is still to show that it is there.
  void set_e_stop_awaited(bool awaited);
  /// A person says go on after an e-stop. False while it is pressed.
  [[nodiscard]] bool resume();

  /// Never wants more room for what it sends.
  static constexpr std::size_t kMaxOut_bytes = kMaxCommand_bytes;
  /// At least each 20 ms, and after each on_bytes. Returns how many bytes of `out` (kMaxOut_bytes or more) are to be
  /// sent now: a command when its time has come, zeros when they cannot wait, else 0.
  [[nodiscard]] std::size_t tick(TimeNs now_ns, std::span<std::uint8_t> out);
  /// When the next command is due.
  [[nodiscard]] TimeNs next_tick_ns() const { return next_tick_ns_; }
  /// Zero speed, LEDs off: to be sent at every good end, several times.
  [[nodiscard]] std::size_t farewell(std::span<std::uint8_t> out);

  /// As of the last tick().
  [[nodiscard]] const BaseState& state() const { return state_; }
  /// One pose for each packet.
  [[nodiscard]] const PoseHistory& poses() const { return poses_; }

 private:
  void on_feedback(const Feedback& feedback);
  void judge_now(TimeNs now_ns);
  [[nodiscard]] Twist next_twist();
  void add_requests(Command& command, TimeNs now_ns);

  const BaseDriverOptions options_;
  PacketReader reader_;
  Odometry odometry_;
  Battery battery_;
  LinkDelay link_delay_;
  RetreatTrail trail_;
  PoseHistory poses_;
  SpeedLimits limits_;
  Outputs outputs_;
  Signals signals_;
  SafetyLatches latches_;
  BaseState state_;

  Twist wanted_;
  TimeNs wanted_ns_ = 0;
  bool rear_was_told_ = false;
  TimeNs rear_told_ns_ = 0;
  std::uint8_t bumper_sides_ = 0, cliff_sides_ = 0, wheel_sides_ = 0;  // since the flag holds
  TimeNs next_tick_ns_ = 0;
  bool has_ticked_ = false;
  std::uint16_t sent_outputs_ = 0;
  TimeNs outputs_sent_ns_ = 0;
  TimeNs asked_ns_ = 0;
  bool has_asked_ = false;
};

}  // namespace g3d::hal::kobuki
