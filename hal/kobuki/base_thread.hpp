// SPDX-License-Identifier: Apache-2.0
// The BaseDriver at a real line, in a thread of its own: reads what is there every other millisecond, sends each 20 ms,
// feeds the guard's heartbeat, and depends on no other thread: if those that command it or see for it stop, their
// stamps grow old and it stands. Other threads talk to it through latest-value slots alone.
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <vector>

#include "hal/byte_line.hpp"
#include "hal/clock.hpp"
#include "hal/kobuki/base_driver.hpp"
#include "hal/kobuki/line_guard.hpp"
#include "hal/kobuki/line_recorder.hpp"
#include "hal/latest.hpp"
#include "hal/progress_board.hpp"
#include "hal/safety_device.hpp"

namespace g3d::hal::kobuki {

struct BaseThreadOptions {
  BaseDriverOptions driver;
  TimeNs poll_ns = 2'000'000;  ///< between two looks at the line
  int realtime_priority = 40;  ///< SCHED_FIFO, where the system grants it; 0: do not ask
  int farewell_packets = 5;
  TimeNs farewell_gap_ns = 10'000'000;
  /// Told by the thread at every tick how late it was. Must not wait. May be empty.
  std::function<void(TimeNs late_ns)> on_tick;
  /// Asked at every look at the line, and told of the robot. They outlive the thread.
  std::vector<SafetyDevice*> safety_devices;
  ProgressEntry* progress = nullptr;  ///< ticked at every look
};

/// How the thread itself is.
struct BaseThreadHealth {
  bool is_realtime = false;
  bool line_is_up = false;
  std::uint64_t line_losses = 0;
  std::uint64_t refused_writes = 0;  ///< commands that the line did not take
  TimeNs latest_tick_ns = 0;         ///< by how much the latest tick was late
};

class BaseThread {
 public:
  /// `line` and `clock` outlive this; so do `guard` and `recorder`, which may be null.
  BaseThread(ByteLine& line, Clock& clock, const BaseThreadOptions& options = {}, LineGuard* guard = nullptr,
             LineRecorder* recorder = nullptr);
  ~BaseThread();
  BaseThread(const BaseThread&) = delete;
  BaseThread& operator=(const BaseThread&) = delete;

  void start();
  /// Zeros, then the end of the thread. Once stopped it is not started again.
  void stop();

  /// One thread, the navigator. `stamp_ns` is when it was decided.
  void set_command(const Twist& wanted, TimeNs stamp_ns) { command_.write({wanted, stamp_ns}); }
  /// Any thread. See BaseDriver.
  void set_camera_alive(TimeNs stamp_ns) { image_ns_.store(stamp_ns, std::memory_order_release); }
  void set_rear_free(TimeNs stamp_ns) { rear_free_ns_.store(stamp_ns, std::memory_order_release); }
  void set_e_stop(bool pressed) {
    // Both are kept: a press and release between two looks must latch all the same.
    if (pressed) e_stops_.fetch_add(1, std::memory_order_release);
    e_stop_pressed_.store(pressed, std::memory_order_release);
  }
  void resume() { resumes_.fetch_add(1, std::memory_order_release); }

  /// Used by the thread, after stop().
  [[nodiscard]] std::int64_t cpu_ns() const { return cpu_ns_; }
  [[nodiscard]] const Latest<BaseState>& state() const { return state_; }
  [[nodiscard]] const Latest<PoseHistory>& poses() const { return poses_; }
  [[nodiscard]] const Latest<BaseThreadHealth>& health() const { return health_; }

 private:
  struct Wish {
    Twist wanted;
    TimeNs stamp_ns = 0;
  };
  static constexpr TimeNs kNever_ns = INT64_MIN;

  void run();
  void take_wishes();
  [[nodiscard]] StopWord ask_devices();
  void tell_devices();
  [[nodiscard]] bool read_line();
  void send(std::span<const std::uint8_t> bytes);
  void say_farewell();

  ByteLine& line_;
  Clock& clock_;
  const BaseThreadOptions options_;
  LineGuard* const guard_;
  LineRecorder* const recorder_;

  // Written by other threads.
  Latest<Wish> command_;
  std::atomic<TimeNs> image_ns_{kNever_ns}, rear_free_ns_{kNever_ns};
  std::atomic<bool> e_stop_pressed_{false};
  std::atomic<std::uint32_t> e_stops_{0}, resumes_{0};
  std::atomic<bool> ending_{false};

  // The thread's own.
  BaseDriver driver_;
  BaseThreadHealth own_health_;
  std::uint64_t seen_command_ = 0;
  std::uint32_t seen_e_stops_ = 0, seen_resumes_ = 0;
  std::int64_t cpu_ns_ = 0;

  Latest<BaseState> state_;
  Latest<PoseHistory> poses_;
  Latest<BaseThreadHealth> health_;
  std::thread thread_;
};

}  // namespace g3d::hal::kobuki
