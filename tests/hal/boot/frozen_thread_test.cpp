// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/frozen_thread.hpp"

#include <pthread.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

using namespace g3d::hal;
using namespace g3d::hal::boot;

namespace {

struct Counts {
  std::atomic<std::uint64_t> main{0}, other{0};
};

/// Whether a count goes on within a second.
bool goes_on(const std::atomic<std::uint64_t>& count) {
  const std::uint64_t before = count.load();
  for (int i = 0; i < 200 && count.load() == before; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return count.load() != before;
}

}  // namespace

TEST_CASE("one thread of a process hangs, and the others run on", "[boot]") {
  auto* const counts =
      static_cast<Counts*>(::mmap(nullptr, sizeof(Counts), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  new (counts) Counts;
  const pid_t child = ::fork();
  if (child == 0) {
    std::thread other([counts] {
      (void)::pthread_setname_np(::pthread_self(), "victim");
      for (;;) {
        ++counts->other;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
    for (;;) {
      ++counts->main;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  CHECK(goes_on(counts->other));
  CHECK(goes_on(counts->main));
  CHECK(threads_of(child).size() == 2);
  const auto missing = freeze_thread(child, "nobody");
  CHECK(missing.error().reason == Reason::not_found);
  CHECK(missing.error().text.find("victim") != std::string::npos);

  const auto frozen = freeze_thread(child, "victim");
  if (frozen.ok()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    CHECK_FALSE(goes_on(counts->other));
    CHECK(goes_on(counts->main));
  } else {
    WARN("skipped: no ptrace here: " << frozen.error().text);
  }
  ::kill(child, SIGKILL);
  int status = 0;
  // The thread that hangs is a child of whoever made it hang, and ends before its process does.
  while (::waitpid(-1, &status, __WALL) >= 0) {
  }
  ::munmap(counts, sizeof(Counts));
}
