// SPDX-License-Identifier: Apache-2.0
// What is known of the emergency-stop node on the bus: alive by its heartbeat, ready by the state in it, and whether it
// has an emergency. All three must be well, else the robot stands. Pure: knows neither bus nor clock.
#pragma once

#include "hal/can/canopen.hpp"
#include "hal/safety_device.hpp"

namespace g3d::hal::can {

struct EstopNodeOptions {
  std::uint8_t node = 1;              ///< 1 to 127
  TimeNs heartbeat_ns = 500'000'000;  ///< without one for so long it counts as lost
};

class EstopNode {
 public:
  explicit EstopNode(const EstopNodeOptions& options) : options_(options) {}

  /// Messages of other nodes are ignored.
  void on_message(const Message& message, TimeNs received_ns);
  /// `not_yet` until it has once been alive, operational and without an emergency; later whatever is amiss is a stop,
  /// as is an emergency at any time.
  [[nodiscard]] StopWord word(TimeNs now_ns);

  [[nodiscard]] bool is_alive(TimeNs now_ns) const;
  [[nodiscard]] bool has_emergency() const { return has_emergency_; }
  [[nodiscard]] NmtState state() const { return state_; }
  [[nodiscard]] const Emergency& last_emergency() const { return last_emergency_; }
  [[nodiscard]] std::uint64_t heartbeats() const { return heartbeats_; }
  [[nodiscard]] std::uint64_t emergencies() const { return emergencies_; }
  [[nodiscard]] std::uint64_t losses() const { return losses_; }

 private:
  const EstopNodeOptions options_;
  bool was_heard_ = false;
  bool was_well_ = false;
  bool was_alive_ = false;
  bool has_emergency_ = false;
  bool stop_is_due_ = false;  ///< something was amiss since the last word(), though it may be well again
  TimeNs last_heartbeat_ns_ = 0;
  NmtState state_ = NmtState::boot_up;
  Emergency last_emergency_;
  std::uint64_t heartbeats_ = 0, emergencies_ = 0, losses_ = 0;
};

}  // namespace g3d::hal::can
