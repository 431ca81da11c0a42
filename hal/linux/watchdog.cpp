// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/watchdog.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace g3d::hal {
namespace {

Error watchdog_error(const std::string& path, int error) {
  const auto say = [&](Reason reason, const char* remedy) {
    return Error{reason, fmt::format("{}: {}; {}", path, std::strerror(error), remedy)};
  };
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return say(Reason::not_found, "load the watchdog's driver, or set watchdog.device = \"none\" in the board file");
    case EACCES:
    case EPERM:
      return say(Reason::no_permission, "run it as root, or let a udev rule give the user the device");
    case EBUSY:
      return say(Reason::no_capacity, "another program feeds it (systemd: RuntimeWatchdogSec); leave it to one");
    case ENOTTY:
    case EINVAL:
      return say(Reason::unsupported, "that is no watchdog; see watchdog.device in the board file");
    default:
      return say(Reason::io_error, "see dmesg for what its driver says");
  }
}

}  // namespace

Result<std::unique_ptr<LinuxWatchdog>> LinuxWatchdog::open(const std::string& path, int timeout_s) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return watchdog_error(path, errno);
  watchdog_info info{};
  if (::ioctl(fd, WDIOC_GETSUPPORT, &info) != 0) {
    const int error = errno;
    ::close(fd);
    return watchdog_error(path, error);
  }
  const auto* identity = reinterpret_cast<const char*>(info.identity);
  auto watchdog =
      std::make_unique<LinuxWatchdog>(fd, timeout_s, std::string(identity, strnlen(identity, sizeof info.identity)));
  int granted_s = timeout_s;
  // Some have one timeout only; then that is what it is.
  if (::ioctl(fd, WDIOC_SETTIMEOUT, &granted_s) != 0 && ::ioctl(fd, WDIOC_GETTIMEOUT, &granted_s) != 0) {
    granted_s = timeout_s;
  }
  watchdog->timeout_s_ = std::max(granted_s, 1);
  int boot_status = 0;
  watchdog->has_bitten_ = ::ioctl(fd, WDIOC_GETBOOTSTATUS, &boot_status) == 0 && (boot_status & WDIOF_CARDRESET) != 0;
  (void)watchdog->feed();
  return watchdog;
}

LinuxWatchdog::LinuxWatchdog(int fd, int timeout_s, std::string name)
    : fd_(fd), timeout_s_(timeout_s), name_(std::move(name)) {}

LinuxWatchdog::~LinuxWatchdog() {
  if (fd_ >= 0) ::close(fd_);
}

bool LinuxWatchdog::feed() { return fd_ >= 0 && ::write(fd_, "k", 1) == 1; }

void LinuxWatchdog::disarm() {
  if (fd_ < 0) return;
  // The magic of the kernel's watchdog interface: closed after a V it stops, else it goes on.
  (void)!::write(fd_, "V", 1);
  ::close(std::exchange(fd_, -1));
}

}  // namespace g3d::hal
