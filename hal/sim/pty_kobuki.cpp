// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/pty_kobuki.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace g3d::hal {
namespace {

Error system_error(const char* what) {
  return {Reason::io_error, fmt::format("pseudo-terminal: {}: {}; is /dev/pts mounted?", what, std::strerror(errno))};
}

}  // namespace

Result<PtyKobuki> PtyKobuki::open(const std::string& link) {
  PtyKobuki pty(link);
  if (auto plugged = pty.plug_in(); !plugged) return plugged.error();
  return pty;
}

PtyKobuki::PtyKobuki(PtyKobuki&& other) noexcept
    : link_(std::exchange(other.link_, {})),
      path_(std::exchange(other.path_, {})),
      master_(std::exchange(other.master_, -1)),
      keep_(std::exchange(other.keep_, -1)),
      lost_bytes_(other.lost_bytes_) {}

PtyKobuki::~PtyKobuki() { pull_out(); }

void PtyKobuki::pull_out() {
  if (master_ < 0) return;
  if (!link_.empty()) (void)::unlink(link_.c_str());
  (void)::close(keep_);
  (void)::close(master_);
  master_ = keep_ = -1;
  path_.clear();
}

Result<void> PtyKobuki::plug_in() {
  if (master_ >= 0) return {};
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0) return system_error("none to be had");
  std::array<char, 64> name{};
  if (::grantpt(master_) != 0 || ::unlockpt(master_) != 0 || ::ptsname_r(master_, name.data(), name.size()) != 0) {
    const Error error = system_error("cannot be unlocked");
    (void)::close(std::exchange(master_, -1));
    return error;
  }
  keep_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  termios raw{};
  if (keep_ < 0 || ::tcgetattr(keep_, &raw) != 0) {
    const Error error = system_error("cannot be opened");
    if (keep_ >= 0) (void)::close(std::exchange(keep_, -1));
    (void)::close(std::exchange(master_, -1));
    return error;
  }
  ::cfmakeraw(&raw);  // no echo: the base must not hear itself before the host sets its own mode
  (void)::tcsetattr(keep_, TCSANOW, &raw);
  path_ = name.data();
  if (link_.empty()) return {};
  (void)::unlink(link_.c_str());
  if (::symlink(path_.c_str(), link_.c_str()) != 0) {
    const Error error{Reason::io_error,
                      fmt::format("{}: cannot be made a link to {}: {}; name a place that can be written", link_, path_,
                                  std::strerror(errno))};
    pull_out();
    return error;
  }
  return {};
}

void PtyKobuki::pump(ByteLine& device) {
  if (master_ < 0) return;
  std::array<std::uint8_t, 512> bytes;
  for (;;) {
    const ssize_t n = ::read(master_, bytes.data(), bytes.size());
    if (n <= 0) break;
    if (!device.write({bytes.data(), static_cast<std::size_t>(n)})) lost_bytes_ += static_cast<std::uint64_t>(n);
  }
  for (std::size_t n = device.read(bytes); n > 0; n = device.read(bytes)) {
    const ssize_t written = ::write(master_, bytes.data(), n);
    lost_bytes_ += n - static_cast<std::size_t>(written > 0 ? written : 0);
  }
}

}  // namespace g3d::hal
