// SPDX-License-Identifier: Apache-2.0
// The robot as a node on a CANopen bus, as a SafetyDevice: listens to the emergency-stop node and to network
// management, says its own heartbeat and status. Runs in the base's thread, so its heartbeat says that this thread
// lives.
#pragma once

#include <array>

#include "hal/can/estop_node.hpp"

namespace g3d::hal {
class TextRecorder;
}

namespace g3d::hal::can {

struct CanSafetyOptions {
  std::uint8_t own_node = 10;  ///< 1 to 127, another than the stop node's
  bool has_estop = true;       ///< false: nobody on the bus may stop us but network management
  EstopNodeOptions estop;
  bool starts_estop = false;  ///< be its network master: start it when it waits to be started
  TimeNs heartbeat_ns = 100'000'000;
  TimeNs status_ns = 100'000'000;
  const char* interface = "can0";  ///< what the recording calls it; outlives this
};

struct CanSafetyCounts {
  std::uint64_t frames = 0;  ///< read, in all
  std::array<std::uint64_t, static_cast<std::size_t>(NoMessage::count_)> ignored{};
  std::uint64_t starts_sent = 0;   ///< of the stop node
  std::uint64_t orders = 0;        ///< from a network master, for us
  std::uint64_t left_waiting = 0;  ///< looks that ended before the bus had nothing more
};

class CanSafety final : public SafetyDevice {
 public:
  /// `port` outlives this; `recorder` too, and may be null.
  CanSafety(CanPort& port, const CanSafetyOptions& options, TextRecorder* recorder = nullptr);

  [[nodiscard]] StopWord look(TimeNs now_ns) override;
  void show(const SafetyNews& news, TimeNs now_ns) override;
  void say_farewell(TimeNs now_ns) override;

  // The same thread, or after it has ended
  [[nodiscard]] const EstopNode& estop() const { return estop_; }
  [[nodiscard]] const CanSafetyCounts& counts() const { return counts_; }
  [[nodiscard]] NmtState state() const { return state_; }

 private:
  void take(const Message& message, TimeNs now_ns);
  void obey(const NmtOrder& order);
  void send(const CanFrame& frame, TimeNs now_ns);
  void record(const CanFrame& frame, TimeNs t_ns);

  CanPort& port_;
  const CanSafetyOptions options_;
  TextRecorder* const recorder_;
  EstopNode estop_;
  CanSafetyCounts counts_;
  NmtState state_ = NmtState::boot_up;
  bool was_told_to_stop_ = false;
  bool has_begun_ = false;
  TimeNs next_heartbeat_ns_ = 0, next_status_ns_ = 0, next_start_ns_ = 0;
};

}  // namespace g3d::hal::can
