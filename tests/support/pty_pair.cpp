// SPDX-License-Identifier: Apache-2.0
#include "tests/support/pty_pair.hpp"

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace g3d::test {
namespace {

[[noreturn]] void give_up(const char* what) {
  std::perror(what);
  std::abort();
}

}  // namespace

PtyPair::PtyPair() {
  fd_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0 || ::grantpt(fd_) != 0 || ::unlockpt(fd_) != 0) give_up("posix_openpt");
  std::array<char, 128> name{};
  if (::ptsname_r(fd_, name.data(), name.size()) != 0) give_up("ptsname_r");
  path_ = name.data();
  // Until the port sets its own mode, the terminal would echo what the far end sends.
  termios t{};
  if (::tcgetattr(fd_, &t) != 0) give_up("tcgetattr");
  ::cfmakeraw(&t);
  if (::tcsetattr(fd_, TCSANOW, &t) != 0) give_up("tcsetattr");
}

PtyPair::~PtyPair() { ::close(fd_); }

void PtyPair::write(std::span<const std::uint8_t> bytes) const {
  if (::write(fd_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) give_up("write to pty");
}

std::vector<std::uint8_t> PtyPair::read_all(std::size_t count, int timeout_ms) const {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 256> buffer;
  pollfd poll_fd{fd_, POLLIN, 0};
  while (bytes.size() < count && ::poll(&poll_fd, 1, timeout_ms) > 0) {
    const ssize_t got = ::read(fd_, buffer.data(), std::min(buffer.size(), count - bytes.size()));
    if (got <= 0) break;
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + got);
  }
  return bytes;
}

}  // namespace g3d::test
