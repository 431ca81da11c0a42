// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/service_notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace g3d::hal {
namespace {

constexpr std::string_view kStatusWord = "STATUS=";
/// Beyond a day nobody means a watchdog, and nanoseconds stay in range.
constexpr std::uint64_t kMostWatchdog_us = 86'400'000'000;

std::uint64_t number_of(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failed == std::errc{} && end == text.data() + text.size() ? number : 0;
}

/// A connected socket, or -1.
int connect_notify(std::string_view address) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  const bool is_abstract = address.starts_with('@');
  if (address.size() < 2 || address.size() >= sizeof to.sun_path || (!is_abstract && address.front() != '/')) return -1;
  std::memcpy(to.sun_path, address.data(), address.size());
  if (is_abstract) to.sun_path[0] = '\0';  // such a name ends with its length, not with a zero
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size() + (is_abstract ? 0 : 1));
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0 || ::connect(fd, reinterpret_cast<const sockaddr*>(&to), size) == 0) return fd;
  ::close(fd);
  return -1;
}

}  // namespace

std::string_view ServiceNotify::variable(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? std::string_view(value) : std::string_view{};
}

ServiceNotify::ServiceNotify(std::string_view address, std::string_view watchdog_us, std::string_view watchdog_pid)
    : fd_(connect_notify(address)) {
  const bool is_meant = watchdog_pid.empty() || number_of(watchdog_pid) == static_cast<std::uint64_t>(::getpid());
  if (fd_ < 0 || !is_meant) return;
  const std::uint64_t period_us = number_of(watchdog_us);
  if (period_us <= kMostWatchdog_us) alive_period_ns_ = static_cast<TimeNs>(period_us) * 1000 / 2;
}

ServiceNotify::~ServiceNotify() {
  if (fd_ >= 0) ::close(fd_);
}

bool ServiceNotify::send(std::string_view text) {
  if (fd_ < 0) return false;
  const bool is_sent = ::send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  (is_sent ? sent_ : lost_).fetch_add(1, std::memory_order_relaxed);
  return is_sent;
}

bool ServiceNotify::allow_silence(TimeNs silence_ns) {
  if (alive_period_ns_ == 0) return false;
  constexpr std::string_view kWord = "WATCHDOG_USEC=";
  std::array<char, 40> message;
  char* const digits = std::copy(kWord.begin(), kWord.end(), message.data());
  const auto end = std::to_chars(digits, message.data() + message.size(), std::max<TimeNs>(1, silence_ns / 1000)).ptr;
  return send({message.data(), static_cast<std::size_t>(end - message.data())});
}

bool ServiceNotify::status(std::string_view text) {
  std::array<char, kStatusWord.size() + kMostStatus_bytes> message;
  const std::size_t size = std::min(text.size(), kMostStatus_bytes);
  char* const end = std::copy(kStatusWord.begin(), kStatusWord.end(), message.data());
  // A second line would be a second word, such as READY=1.
  std::transform(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size), end,
                 [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c; });
  return send({message.data(), kStatusWord.size() + size});
}

}  // namespace g3d::hal
