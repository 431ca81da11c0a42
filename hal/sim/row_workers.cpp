// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/row_workers.hpp"

#include <cassert>

namespace g3d::hal {

RowWorkers::RowWorkers(int threads) {
  assert(threads >= 1);
  threads_.reserve(static_cast<std::size_t>(threads - 1));
  for (int i = 1; i < threads; ++i) threads_.emplace_back([this] { serve(); });
}

RowWorkers::~RowWorkers() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  begin_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void RowWorkers::start(int rows, const void* context, Call call) {
  {
    const std::lock_guard lock(mutex_);
    rows_ = rows;
    context_ = context;
    call_ = call;
    next_row_.store(0, std::memory_order_relaxed);  // published by the mutex
    busy_ = static_cast<int>(threads_.size());
    ++round_;
  }
  begin_.notify_all();
  take_rows();
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
}

void RowWorkers::take_rows() {
  for (;;) {
    const int row = next_row_.fetch_add(1, std::memory_order_relaxed);  // rows do not depend on each other
    if (row >= rows_) return;
    call_(context_, row);
  }
}

void RowWorkers::serve() {
  std::uint64_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      begin_.wait(lock, [&] { return stop_ || round_ != seen; });
      if (stop_) return;
      seen = round_;
    }
    take_rows();
    {
      const std::lock_guard lock(mutex_);
      --busy_;
    }
    done_.notify_one();
  }
}

}  // namespace g3d::hal
