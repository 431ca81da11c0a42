// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/thread_pool.hpp"

#include <pthread.h>

#include "hal/linux/cpu_time.hpp"

namespace g3d::mapper::cpu {
namespace {

// About 20 us on today's cores: longer than the gaps between the loops of one frame, far shorter than a time slice.
constexpr int kSpins = 4000;
constexpr std::uint32_t kNoChunk = 0xFFFFFFFFU;

std::uint32_t generation_of(std::uint64_t ticket) { return static_cast<std::uint32_t>(ticket >> 32); }
std::uint32_t chunk_of(std::uint64_t ticket) { return static_cast<std::uint32_t>(ticket); }

}  // namespace

ThreadPool::ThreadPool(int threads) {
  workers_.reserve(threads > 1 ? static_cast<std::size_t>(threads - 1) : 0U);
  for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { worker_loop(); });
}

ThreadPool::~ThreadPool() {
  stop_.store(true, std::memory_order_release);
  wake_.fetch_add(1, std::memory_order_release);
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

std::int64_t ThreadPool::workers_cpu_ns() {
  std::int64_t sum_ns = 0;
  for (std::thread& worker : workers_) sum_ns += hal::cpu_ns_of(worker.native_handle());
  return sum_ns;
}

void ThreadPool::run(std::uint32_t chunks, Function function, void* context) {
  const std::uint32_t generation = generation_of(ticket_.load(std::memory_order_relaxed)) + 1;
  // The old ticket goes first: a late worker of the last job, which sees that the new one has more chunks, must not
  // take the next chunk under the old ticket. Whoever reads the new number of chunks fails to exchange the old ticket.
  ticket_.store(static_cast<std::uint64_t>(generation) << 32 | kNoChunk, std::memory_order_relaxed);
  function_.store(function, std::memory_order_relaxed);
  context_.store(context, std::memory_order_relaxed);
  done_.store(0, std::memory_order_relaxed);
  chunks_.store(chunks, std::memory_order_release);
  ticket_.store(static_cast<std::uint64_t>(generation) << 32, std::memory_order_release);
  wake_.store(generation, std::memory_order_release);
  wake_.notify_all();
  work(generation);
  for (int spins = 0; done_.load(std::memory_order_acquire) != chunks; ++spins) {
    if (spins > kSpins) std::this_thread::yield();
  }
}

void ThreadPool::work(std::uint32_t generation) {
  for (;;) {
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    const std::uint32_t chunks = chunks_.load(std::memory_order_acquire);
    const Function function = function_.load(std::memory_order_relaxed);
    void* const context = context_.load(std::memory_order_relaxed);
    if (generation_of(ticket) != generation || chunk_of(ticket) >= chunks) return;
    if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel, std::memory_order_relaxed))
      continue;
    function(context, chunk_of(ticket));
    done_.fetch_add(1, std::memory_order_acq_rel);
  }
}

void ThreadPool::worker_loop() {
  (void)pthread_setname_np(pthread_self(), "mapper_worker");
  std::uint32_t seen = 0;
  for (;;) {
    std::uint32_t generation = wake_.load(std::memory_order_acquire);
    for (int spins = 0; generation == seen && spins < kSpins; ++spins)
      generation = wake_.load(std::memory_order_acquire);
    if (generation == seen) {
      wake_.wait(seen, std::memory_order_acquire);
      continue;
    }
    seen = generation;
    if (stop_.load(std::memory_order_acquire)) return;
    work(generation);
  }
}

}  // namespace g3d::mapper::cpu
