// SPDX-License-Identifier: Apache-2.0
// Makes one thread of another process hang, so that it can be shown what a watchdog does then: the thread is stopped
// from outside, as a debugger would, and all others run on. Linux alone; one thread.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal::boot {

struct ThreadName {
  pid_t id = 0;
  std::string name;
};
[[nodiscard]] std::vector<ThreadName> threads_of(pid_t process);
/// For good: until that process or this one ends. Errors: not_found, no_permission, io_error.
[[nodiscard]] Result<void> freeze_thread(pid_t process, std::string_view name);

}  // namespace g3d::hal::boot
