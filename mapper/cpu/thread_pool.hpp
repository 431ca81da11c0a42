// SPDX-License-Identifier: Apache-2.0
// A few threads that share out the chunks of one loop. The caller works too and waits only for chunks that somebody has
// begun, so that a worker which does not get its core (another process holds it) delays nothing. Idle workers spin for
// some microseconds, then sleep: spinning barriers collapse when a core is busy, sleeping ones cost a wake per loop.
// Threads: parallel_for() from one thread at a time. No allocation after construction.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace g3d::mapper::cpu {

class ThreadPool {
 public:
  /// `threads` in all, the caller included; 1 means no worker at all.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  [[nodiscard]] int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// CPU time of all workers so far, without the caller's. Any thread.
  [[nodiscard]] std::int64_t workers_cpu_ns();

  /// Calls body(chunk) once for every chunk in [0, chunks), in any order and on any thread; returns when all are done.
  template <typename Body>
  void parallel_for(std::uint32_t chunks, Body&& body) {
    if (workers_.empty() || chunks < 2) {
      for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) body(chunk);
      return;
    }
    using Plain = std::remove_reference_t<Body>;
    run(
        chunks, [](void* context, std::uint32_t chunk) { (*static_cast<Plain*>(context))(chunk); }, &body);
  }

 private:
  using Function = void (*)(void*, std::uint32_t);
  void run(std::uint32_t chunks, Function function, void* context);
  /// Takes chunks of the job of `generation` until none is left.
  void work(std::uint32_t generation);
  void worker_loop();

  // High half: generation of the job, low half: next chunk. One compare-exchange claims a chunk of exactly that job.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};
  alignas(64) std::atomic<std::uint32_t> done_{0};
  alignas(64) std::atomic<std::uint32_t> wake_{0};  ///< generation, for sleepers; changed after ticket_
  std::atomic<std::uint32_t> chunks_{0};
  std::atomic<Function> function_{nullptr};
  std::atomic<void*> context_{nullptr};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

}  // namespace g3d::mapper::cpu
