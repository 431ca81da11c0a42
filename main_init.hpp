// SPDX-License-Identifier: Apache-2.0
// The same executable as the first process of a machine that has no other operating system to look after: it mounts,
// loads modules, opens the watchdog, chooses the system slot, brings up the network, and then supervises: it starts the
// robot (`g3dmap run`), whose line guard and GPU helper are the robot's own children, starts again what dies, reaps
// what is left, keeps the log, and feeds the watchdog only while the robot says that all its threads make progress.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/boot/child_process.hpp"
#include "hal/boot/init_config.hpp"
#include "hal/boot/log_ring.hpp"
#include "hal/boot/network_keeper.hpp"
#include "hal/boot/notify_socket.hpp"
#include "hal/boot/slot_store.hpp"
#include "hal/clock.hpp"

namespace g3d {

/// Whether the kernel has started it as such: process 1 of a container is another matter.
[[nodiscard]] bool is_first_process(std::string_view program);
/// What `g3dmap` does if it is process 1. Returns only if the system refuses to end.
int run_init();

namespace init {

/// Everything that is said goes to the console and into the log.
class Speaker {
 public:
  explicit Speaker(const hal::Clock& clock) : clock_(clock) {}
  void say(std::string_view line);
  /// What others have said.
  void pass_on(std::string_view who, std::string_view line);
  /// Errors: those of the folder. What was said before goes there too.
  [[nodiscard]] hal::Result<void> open_log(const std::string& folder);
  void close_log() { log_.close(); }
  [[nodiscard]] const hal::boot::LogRing& log() const { return log_; }

 private:
  const hal::Clock& clock_;
  hal::boot::LogRing log_{hal::boot::LogRing::Bounds{}};
  std::vector<std::string> early_;
  bool is_early_ = true;
};

/// /dev/watchdog. A machine without one runs all the same, and says so.
class HardwareWatchdog {
 public:
  HardwareWatchdog() = default;
  ~HardwareWatchdog() = default;  // stays armed: whatever ends this process, the machine starts anew
  HardwareWatchdog(const HardwareWatchdog&) = delete;
  HardwareWatchdog& operator=(const HardwareWatchdog&) = delete;
  /// What became of it, for people.
  [[nodiscard]] std::string open(int timeout_s);
  void set_timeout(int timeout_s);
  void feed();
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  /// Whether this start is one that it has caused, if the driver knows.
  [[nodiscard]] bool has_bitten() const { return has_bitten_; }

 private:
  int fd_ = -1;
  bool has_bitten_ = false;
};

/// The machine as the start has left it.
struct Machine {
  explicit Machine(const hal::Clock& clock) : speaker(clock) {}
  Speaker speaker;
  HardwareWatchdog watchdog;
  hal::boot::InitConfig config;
  std::string program = "/init";  ///< the robot's; /init: neither system slot can be used
  std::string slot_a, slot_b;     ///< devices; empty: there is none
  std::optional<hal::Slot> slot;  ///< that runs
  bool is_on_trial = false;
  bool has_data = false;  ///< /data is a disk, not memory
};

/// From nothing to a machine that can run a robot. Never fails: what is missing is said, and done without.
void start_machine(Machine& machine, const hal::Clock& clock);

inline constexpr const char* kSlotBook = "/data/slots.state";
inline constexpr const char* kClockFile = "/data/clock";

/// Looks after the robot until the machine is to end.
class Supervisor {
 public:
  Supervisor(Machine& machine, const hal::Clock& clock);
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;
  enum class End { reboot, power_off };
  [[nodiscard]] End run();

 private:
  void start_robot();
  void start_receiver();
  void start_network();
  void wait_for_something();
  void on_signals();
  void reap();
  void on_robot_end(const hal::boot::ProcessEnd& end);
  void on_notices();
  void on_console();
  void obey(const std::string& line);
  void run_beside(const std::string& words);
  void tell_robot(const std::string& word);
  [[nodiscard]] std::string status_text() const;
  void look_after_health();
  void look_after_time();
  void look_after_network();
  void end_with(End end);
  void stop_robot();
  [[nodiscard]] std::string robot_folder() const;

  Machine& machine_;
  const hal::Clock& clock_;
  hal::boot::RobotHealth health_;
  hal::HealthTrial trial_;
  hal::boot::RestartPolicy restarts_;
  hal::boot::ChildProcess robot_;
  hal::boot::ChildProcess receiver_;  ///< of updates
  hal::boot::ChildProcess aside_;     ///< what a person wants besides
  std::unique_ptr<hal::boot::NotifySocket> notices_;
  std::unique_ptr<hal::boot::NetworkKeeper> network_;
  int signals_fd_ = -1;
  std::string console_line_;
  std::string robot_status_;
  std::optional<End> end_;
  bool is_told_good_ = false;
  bool was_fed_ = true;
  bool console_is_gone_ = false;
  int starts_ = 0;
  hal::TimeNs robot_started_ns_ = 0;
  hal::TimeNs start_again_ns_ = 0;  ///< INT64_MAX: not by itself
  hal::TimeNs start_receiver_ns_ = 0;
  hal::TimeNs save_time_ns_ = 0;
  hal::TimeNs look_for_card_ns_ = 0;
  std::optional<std::uint32_t> address_;  ///< as last said
};

}  // namespace init
}  // namespace g3d
