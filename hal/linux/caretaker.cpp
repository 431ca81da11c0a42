// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/caretaker.hpp"

#include <pthread.h>

#include <utility>

namespace g3d::hal {

Caretaker::Caretaker(ProgressBoard& board, Clock& clock, CaretakerOptions options, Watchdog* watchdog)
    : board_(board), clock_(clock), options_(std::move(options)), watchdog_(watchdog) {}

Caretaker::~Caretaker() { end_thread(); }

void Caretaker::start() {
  if (!thread_.joinable() && !ending_.load(std::memory_order_relaxed)) thread_ = std::thread([this] { run(); });
}

void Caretaker::end_thread() {
  ending_.store(true, std::memory_order_release);
  if (thread_.joinable()) thread_.join();
}

void Caretaker::stop() {
  end_thread();
  if (watchdog_ != nullptr) watchdog_->disarm();
}

void Caretaker::run() {
  (void)pthread_setname_np(pthread_self(), "caretaker");
  while (!ending_.load(std::memory_order_acquire)) {
    for (const auto& chore : options_.chores) chore(clock_.now());
    look(clock_.now());
    clock_.sleep_until(clock_.now() + options_.period_ns);
  }
}

void Caretaker::look(TimeNs now_ns) {
  const ProgressBoard::Late late = board_.find_late(now_ns);
  const std::string name = late.name != nullptr ? *late.name : std::string();
  if (name != late_) {
    late_ = name;
    if (options_.on_late) options_.on_late(late_, late.name != nullptr ? now_ns - late.since_ns : 0);
  }
  if (now_ns < next_feed_ns_) return;
  next_feed_ns_ = now_ns + options_.feed_ns;
  if (late.name != nullptr) {
    ++own_counts_.withheld;
  } else {
    if (watchdog_ != nullptr) ++(watchdog_->feed() ? own_counts_.feeds : own_counts_.refused_feeds);
    if (options_.on_all_alive) options_.on_all_alive();
  }
  counts_.write(own_counts_);
}

}  // namespace g3d::hal
