// SPDX-License-Identifier: Apache-2.0
// What a robot has besides base and camera: the CAN bus, GPIO lines, the watchdog, where its threads run, how warm it
// is. Opened as the board says, handed to the robot's threads, looked after while it runs, and reported at the end.
// What the board does not name does not exist.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "board/board.hpp"
#include "hal/can/can_safety.hpp"
#include "hal/gpio/gpio_safety.hpp"
#include "hal/latest.hpp"
#include "hal/linux/can_keeper.hpp"
#include "hal/linux/caretaker.hpp"
#include "hal/linux/gpio_chip.hpp"
#include "hal/linux/thermal_power.hpp"
#include "hal/linux/thread_plan.hpp"
#include "hal/replay/text_recorder.hpp"
#include "mapper/json_writer.hpp"
#include "nav/robot_threads.hpp"

namespace g3d {

/// The parts of a board that say how its stop devices are wired.
[[nodiscard]] hal::can::CanSafetyOptions can_options(const board::Board& board);
[[nodiscard]] hal::GpioSafetyOptions gpio_options(const board::Board& board);
[[nodiscard]] hal::GpioChipOptions gpio_chip_options(const board::Board& board);

/// How the devices are, for other threads than theirs.
struct BusesNews {
  hal::can::CanCounts can;
  hal::can::CanSafetyCounts can_words;
  hal::can::NmtState estop_state = hal::can::NmtState::boot_up;
  bool estop_alive = false, estop_emergency = false;
  std::uint16_t emergency_code = 0;
  std::uint64_t heartbeats = 0, emergencies = 0, losses = 0;
  hal::GpioCounts gpio;
  hal::EstopFault gpio_fault = hal::EstopFault::none;
  std::uint64_t presses = 0, glitches = 0;
  hal::Conditions conditions;  ///< of the robot
};

class Buses {
 public:
  /// Locks memory, opens what the board names. A CAN interface that is not there yet is waited for, and the robot
  /// stands; every other part that the board names and that is not there is an error. `record_dir`: where can.log and
  /// gpio.log go; empty: nowhere. `board` and `clock` outlive this.
  [[nodiscard]] static hal::Result<std::unique_ptr<Buses>> open(const board::Board& board, hal::Clock& clock,
                                                                const std::string& record_dir);
  ~Buses();

  /// Before the robot's threads are made.
  void equip(nav::RobotThreadsConfig& config);
  /// Called about once a second while all threads make progress; by the caretaker's thread. Before start().
  void set_on_all_alive(std::function<void()> on_all_alive) { on_all_alive_ = std::move(on_all_alive); }
  /// Somebody else holds the watchdog, and is to hear every `period_ns` that all is well. Before start().
  void leave_watchdog(hal::TimeNs period_ns) { supervised_ns_ = period_ns; }
  /// Right before the robot's threads begin.
  void start();
  /// The main thread's own sign of life, while it looks after the robot; and before it does what takes long.
  void tick_main() { hal::tick(main_progress_); }
  void rest_main() { hal::rest(main_progress_); }
  /// The robot stands and its threads have ended: the watchdog is disarmed.
  void stop();
  /// Ends the recordings; waits for the disk. The first error.
  [[nodiscard]] hal::Result<void> finish_recording();

  /// Writes the key "buses" and the object. Any thread.
  void write(mapper::JsonWriter& json) const;
  /// To the request "buses"; nothing: it is another one. Any thread.
  [[nodiscard]] std::optional<std::string> answer(std::string_view request) const;
  /// What the user should know at the end.
  [[nodiscard]] std::vector<std::string> notes() const;

 private:
  class Reporter;
  Buses(const board::Board& board, hal::Clock& clock);
  [[nodiscard]] hal::Result<void> open_can(const std::string& record_dir);
  [[nodiscard]] hal::Result<void> open_gpio(const std::string& record_dir);
  void tend(hal::TimeNs now_ns);
  void write_can(mapper::JsonWriter& json, const BusesNews& news) const;
  void write_gpio(mapper::JsonWriter& json, const BusesNews& news) const;
  void write_machine(mapper::JsonWriter& json) const;

  const board::Board& board_;
  hal::Clock& clock_;
  std::vector<std::string> first_notes_;
  std::unique_ptr<hal::TextRecorder> can_recorder_, gpio_recorder_;
  std::unique_ptr<hal::CanSocket> can_socket_;
  std::unique_ptr<hal::CanKeeper> can_keeper_;
  std::unique_ptr<hal::can::CanSafety> can_;
  std::unique_ptr<hal::GpioChip> gpio_chip_;
  std::unique_ptr<hal::GpioSafety> gpio_;
  std::unique_ptr<Reporter> reporter_;
  hal::ProgressBoard progress_;
  hal::ProgressEntry* main_progress_ = nullptr;
  std::unique_ptr<hal::ThreadSettler> settler_;
  std::unique_ptr<hal::LinuxWatchdog> watchdog_;
  std::function<void()> on_all_alive_;
  hal::TimeNs supervised_ns_ = 0;  ///< 0: nobody else watches
  std::unique_ptr<hal::Caretaker> caretaker_;
  hal::ThermalPowerReader thermal_reader_;
  hal::TimeNs next_slow_chore_ns_ = 0;
  bool has_base_ = false;  ///< a real one

  mutable std::mutex caretakers_;  ///< guards what follows: written by the caretaker, read by whoever asks
  hal::ThermalPower thermal_;
  double hottest_so_far_ = 0.0;
  hal::CanKeeperCounts keeper_counts_;
  std::string keeper_error_;
  hal::ThreadPlanCounts plan_counts_;
  std::vector<std::string> late_notes_;
};

}  // namespace g3d
