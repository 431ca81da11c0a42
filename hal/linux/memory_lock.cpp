// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/memory_lock.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace g3d::hal {

Result<void> lock_program_memory() {
  if (::mlockall(MCL_CURRENT | MCL_ONFAULT) == 0) return {};
  const int error = errno;
  rlimit limit{};
  (void)::getrlimit(RLIMIT_MEMLOCK, &limit);
  if (error == EPERM || error == ENOMEM || error == EAGAIN) {
    return Error{Reason::no_permission,
                 fmt::format("memory is not locked: {}; this process may lock {} kB: raise its limit (LimitMEMLOCK of "
                             "the service), or set threads.lock_memory = \"no\" in the board file",
                             std::strerror(error), limit.rlim_cur / 1024)};
  }
  return Error{error == EINVAL ? Reason::unsupported : Reason::io_error,
               fmt::format("memory is not locked: {}; kernels before 4.4 cannot: set threads.lock_memory = \"no\"",
                           std::strerror(error))};
}

}  // namespace g3d::hal
