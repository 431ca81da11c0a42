// SPDX-License-Identifier: Apache-2.0
// A network namespace for one test: interfaces that may be taken down without anybody noticing. What runs inside sees
// nothing of the machine's network. Not every machine permits it: the test then says that it was skipped.
#pragma once

#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <exception>
#include <functional>
#include <thread>

namespace g3d::test {

/// Takes an interface of the calling thread's network up or down.
inline bool set_interface_up(const char* name, bool is_up) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, name, sizeof request.ifr_name - 1);
  bool is_done = ::ioctl(fd, SIOCGIFFLAGS, &request) == 0;
  const int flags = is_up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP;
  request.ifr_flags = static_cast<short>(flags);
  is_done = is_done && ::ioctl(fd, SIOCSIFFLAGS, &request) == 0;
  ::close(fd);
  return is_done;
}

/// Runs `body` in a network of its own, whose loopback interface is down. False: not permitted here, and it did not
/// run.
[[nodiscard]] inline bool in_own_network(const std::function<void()>& body) {
  bool is_permitted = false;
  std::exception_ptr failure;
  // The thread takes the namespace with it when it ends.
  std::thread([&] {
    is_permitted = ::unshare(CLONE_NEWNET) == 0;
    if (!is_permitted) return;
    try {
      body();
    } catch (...) {
      failure = std::current_exception();
    }
  }).join();
  if (failure) std::rethrow_exception(failure);
  if (!is_permitted) WARN("skipped: no network namespaces here (they take root)");
  return is_permitted;
}

}  // namespace g3d::test
