// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/cpu_time.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

using namespace g3d::hal;

TEST_CASE("a thread that works uses its core, one that sleeps does not", "[threads]") {
  constexpr std::int64_t kWork_ns = 20'000'000;
  std::atomic<bool> is_over{false};
  std::atomic<std::int64_t> own_ns{0};
  std::thread sleeper([&] {
    while (!is_over.load()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
  std::thread worker([&] {
    while (thread_cpu_ns() < kWork_ns) {
    }
    own_ns = thread_cpu_ns();
    while (!is_over.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  while (own_ns.load() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  CHECK(cpu_ns_of(worker.native_handle()) >= own_ns.load());
  CHECK(cpu_ns_of(sleeper.native_handle()) < kWork_ns / 2);
  CHECK(process_cpu_ns() >= kWork_ns);
  is_over = true;
  worker.join();
  sleeper.join();
}
