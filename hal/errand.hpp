// SPDX-License-Identifier: Apache-2.0
// Somebody who does one job at a time in a thread of their own, for work that is too long for the thread that needs it.
// From start() to take() what the job touches is the job's. Thread: all calls from one.
#pragma once

#include <atomic>
#include <cassert>
#include <cstdint>
#include <functional>
#include <thread>
#include <utility>

#include "hal/parking.hpp"

namespace g3d::hal {

class Errand {
 public:
  Errand() : thread_([this] { work(); }) {}
  /// A job under way is finished first.
  ~Errand() {
    jobs_.stop();
    thread_.join();
  }
  Errand(const Errand&) = delete;
  Errand& operator=(const Errand&) = delete;

  /// Not while it is busy. A job that captures no more than a pointer or two is passed on without allocating.
  void start(std::function<void()> job) {
    assert(!is_busy());
    job_ = std::move(job);
    state_.store(State::started, std::memory_order_release);
    jobs_.wake();
  }
  /// From start() to take().
  [[nodiscard]] bool is_busy() const { return state_.load(std::memory_order_acquire) != State::idle; }
  [[nodiscard]] bool is_done() const { return state_.load(std::memory_order_acquire) == State::done; }
  /// Until it is done; not at all if there is no job.
  void wait() {
    (void)done_.wait([this] { return state_.load(std::memory_order_acquire) != State::started; });
  }
  /// What it has done is seen from here on. Only when it is done.
  void take() {
    assert(is_done());
    state_.store(State::idle, std::memory_order_release);
  }

 private:
  enum class State : std::uint8_t { idle, started, done };
  void work() {
    while (jobs_.wait([this] { return state_.load(std::memory_order_acquire) == State::started; })) {
      job_();
      state_.store(State::done, std::memory_order_release);
      done_.wake();
    }
  }

  std::function<void()> job_;
  std::atomic<State> state_{State::idle};
  Parking jobs_;
  Parking done_;
  std::thread thread_;
};

}  // namespace g3d::hal
