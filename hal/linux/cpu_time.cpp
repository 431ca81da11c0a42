// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/cpu_time.hpp"

#include <sys/resource.h>
#include <time.h>

namespace g3d::hal {
namespace {

std::int64_t read_ns(clockid_t clock) {
  timespec used{};
  if (::clock_gettime(clock, &used) != 0) return 0;
  return std::int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
}

}  // namespace

std::int64_t thread_cpu_ns() { return read_ns(CLOCK_THREAD_CPUTIME_ID); }

std::int64_t cpu_ns_of(pthread_t thread) {
  clockid_t clock{};
  return ::pthread_getcpuclockid(thread, &clock) == 0 ? read_ns(clock) : 0;
}

std::int64_t process_cpu_ns() { return read_ns(CLOCK_PROCESS_CPUTIME_ID); }

std::int64_t children_cpu_ns() {
  rusage used{};
  if (::getrusage(RUSAGE_CHILDREN, &used) != 0) return 0;
  const auto to_ns = [](const timeval& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_usec * 1000; };
  return to_ns(used.ru_utime) + to_ns(used.ru_stime);
}

}  // namespace g3d::hal
