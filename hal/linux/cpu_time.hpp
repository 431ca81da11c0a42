// SPDX-License-Identifier: Apache-2.0
// How much of a core a thread has used, by the kernel's count.
#pragma once

#include <pthread.h>

#include <cstdint>

namespace g3d::hal {

/// The calling thread's.
[[nodiscard]] std::int64_t thread_cpu_ns();
/// Another thread's that has not been joined; 0 if the system does not tell.
[[nodiscard]] std::int64_t cpu_ns_of(pthread_t thread);
/// Of the whole process, threads that have ended included.
[[nodiscard]] std::int64_t process_cpu_ns();

/// Of the child processes that have ended and been waited for.
[[nodiscard]] std::int64_t children_cpu_ns();

}  // namespace g3d::hal
