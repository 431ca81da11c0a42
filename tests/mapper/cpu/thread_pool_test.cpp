// SPDX-License-Identifier: Apache-2.0
#include "mapper/cpu/thread_pool.hpp"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <vector>

using g3d::mapper::cpu::ThreadPool;

namespace {

std::set<int> thread_ids() {
  std::set<int> ids;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) {
    ids.insert(std::atoi(entry.path().filename().c_str()));
  }
  return ids;
}

std::atomic<int> held{0};
std::atomic<bool> release{false};

/// Keeps the thread that gets the signal from running, as another process on its core would.
void hold(int) {
  held.fetch_add(1);
  while (!release.load()) {
    const timespec nap{0, 1'000'000};
    nanosleep(&nap, nullptr);
  }
  held.fetch_sub(1);
}

}  // namespace

TEST_CASE("every chunk is done exactly once, for many jobs and any number of threads", "[threads]") {
  for (const int threads : {1, 2, 3, 4, 7}) {
    ThreadPool pool(threads);
    CHECK(pool.threads() == threads);
    int wrong = 0;
    for (std::uint32_t job = 0; job < 300; ++job) {
      const std::uint32_t chunks = job * 7 % 23;
      std::vector<std::atomic<int>> done(chunks);
      pool.parallel_for(chunks, [&](std::uint32_t chunk) { done[chunk].fetch_add(1, std::memory_order_relaxed); });
      for (const auto& count : done) wrong += count.load(std::memory_order_relaxed) == 1 ? 0 : 1;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("what chunks wrote is visible when the loop returns", "[threads]") {
  ThreadPool pool(3);
  std::vector<std::uint64_t> squares(500, 0);  // plain memory: a race here is one that the thread sanitizer reports
  for (std::uint64_t job = 1; job < 100; ++job) {
    pool.parallel_for(500, [&](std::uint32_t chunk) { squares[chunk] = job * chunk; });
    const auto sum = std::accumulate(squares.begin(), squares.end(), std::uint64_t{0});
    REQUIRE(sum == job * 499 * 500 / 2);
  }
}

TEST_CASE("pools come and go, used or not, idle or not", "[threads]") {
  for (int round = 0; round < 50; ++round) {
    ThreadPool pool(1 + round % 4);
    std::atomic<int> sum{0};
    if (round % 3 != 0) pool.parallel_for(10, [&](std::uint32_t chunk) { sum.fetch_add(static_cast<int>(chunk)); });
    CHECK(sum.load() == (round % 3 != 0 ? 45 : 0));
  }
}

TEST_CASE("one thread is the caller alone, and it works in order") {
  const auto before = thread_ids();
  ThreadPool pool(1);
  CHECK(thread_ids() == before);
  std::vector<std::uint32_t> order;
  pool.parallel_for(5, [&](std::uint32_t chunk) { order.push_back(chunk); });
  CHECK(order == std::vector<std::uint32_t>{0, 1, 2, 3, 4});
}

TEST_CASE("a loop ends although no worker ever gets to run") {
  struct sigaction action {};
  struct sigaction old_action {};
  action.sa_handler = hold;
  REQUIRE(sigaction(SIGUSR2, &action, &old_action) == 0);
  release.store(false);
  const auto before = thread_ids();
  {
    ThreadPool pool(3);
    for (const int id : thread_ids()) {
      if (!before.contains(id)) syscall(SYS_tgkill, getpid(), id, SIGUSR2);
    }
    while (held.load() < 2) usleep(100);
    for (int job = 0; job < 20; ++job) {
      int done = 0;  // one thread works, so a plain number will do
      pool.parallel_for(64, [&](std::uint32_t) { ++done; });
      CHECK(done == 64);
    }
    CHECK(held.load() == 2);
    release.store(true);
  }
  sigaction(SIGUSR2, &old_action, nullptr);
}

TEST_CASE("the workers' CPU time is counted without the caller's") {
  ThreadPool alone(1);
  std::atomic<std::uint64_t> sink{0};
  auto work = [&](std::uint32_t chunk) {
    for (std::uint64_t i = 0; i < 100'000; ++i) sink.fetch_add(i ^ chunk, std::memory_order_relaxed);
  };
  alone.parallel_for(20, work);
  CHECK(alone.workers_cpu_ns() == 0);
  ThreadPool pool(2);
  const std::int64_t before_ns = pool.workers_cpu_ns();
  // A busy machine may let the caller do all of one loop, but not of loop after loop.
  for (int i = 0; i < 1000 && pool.workers_cpu_ns() - before_ns < 1'000'000; ++i) pool.parallel_for(20, work);
  CHECK(pool.workers_cpu_ns() - before_ns >= 1'000'000);
}
