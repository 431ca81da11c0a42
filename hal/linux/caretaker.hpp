// SPDX-License-Identifier: Apache-2.0
// The thread that looks after the others: it feeds the watchdog and tells whoever asks that all are alive, but only
// while every thread of the board makes progress; and it does the chores that may wait for the kernel. If it hangs
// itself nobody is fed.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "hal/clock.hpp"
#include "hal/latest.hpp"
#include "hal/linux/watchdog.hpp"
#include "hal/progress_board.hpp"

namespace g3d::hal {

struct CaretakerOptions {
  TimeNs period_ns = 100'000'000;
  TimeNs feed_ns = 1'000'000'000;  ///< how often it feeds, at most half of the watchdog's timeout
  /// Called as often as the watchdog is fed, also without one: for the service manager. May be empty.
  std::function<void()> on_all_alive;
  /// Called once for each time that a thread begins to be late, with its name and how long ago it ticked; and with an
  /// empty name when all are well again. May be empty.
  std::function<void(const std::string& name, TimeNs silent_ns)> on_late;
  /// Each period; may wait for the kernel, for less than half of the shortest limit.
  std::vector<std::function<void(TimeNs now_ns)>> chores;
};

struct CaretakerCounts {
  std::uint64_t feeds = 0;
  std::uint64_t refused_feeds = 0;  ///< by the device
  std::uint64_t withheld = 0;       ///< because a thread was late
};

class Caretaker {
 public:
  /// All outlive this. `watchdog` may be null.
  Caretaker(ProgressBoard& board, Clock& clock, CaretakerOptions options, Watchdog* watchdog);
  /// Without stop() the watchdog stays armed.
  ~Caretaker();
  Caretaker(const Caretaker&) = delete;
  Caretaker& operator=(const Caretaker&) = delete;

  void start();
  /// A good end: the thread ends, and the watchdog is disarmed.
  void stop();
  /// Any thread.
  [[nodiscard]] const Latest<CaretakerCounts>& counts() const { return counts_; }

 private:
  void run();
  void look(TimeNs now_ns);
  void end_thread();

  ProgressBoard& board_;
  Clock& clock_;
  const CaretakerOptions options_;
  Watchdog* const watchdog_;
  std::atomic<bool> ending_{false};
  // The thread's own
  CaretakerCounts own_counts_;
  std::string late_;  ///< who was last said to be
  TimeNs next_feed_ns_ = 0;
  Latest<CaretakerCounts> counts_;
  std::thread thread_;
};

}  // namespace g3d::hal
