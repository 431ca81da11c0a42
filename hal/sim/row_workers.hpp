// SPDX-License-Identifier: Apache-2.0
// A few threads that share the rows of one image. Which thread takes which row is left to chance, so the work on a row
// may depend on nothing but the row. Nothing is allocated after construction.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace g3d::hal {

class RowWorkers {
 public:
  /// `threads` counts the caller of run() too: 1 starts no thread at all.
  explicit RowWorkers(int threads);
  ~RowWorkers();
  RowWorkers(const RowWorkers&) = delete;
  RowWorkers& operator=(const RowWorkers&) = delete;

  /// Calls work(row) once for every row in [0, rows) and returns when all are done. One caller at a time.
  template <typename Work>
  void run(int rows, const Work& work) {
    start(rows, &work, [](const void* context, int row) { (*static_cast<const Work*>(context))(row); });
  }

 private:
  using Call = void (*)(const void* context, int row);

  void start(int rows, const void* context, Call call);
  void serve();
  void take_rows();

  std::mutex mutex_;
  std::condition_variable begin_;
  std::condition_variable done_;
  std::uint64_t round_ = 0;  ///< counts run() calls; guarded by mutex_, as are the next two
  int busy_ = 0;
  bool stop_ = false;
  // Written by run() alone while no worker is busy.
  int rows_ = 0;
  const void* context_ = nullptr;
  Call call_ = nullptr;
  std::atomic<int> next_row_{0};
  std::vector<std::thread> threads_;
};

}  // namespace g3d::hal
