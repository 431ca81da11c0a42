// SPDX-License-Identifier: Apache-2.0
#include "hal/sim/socket_cable.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace g3d::hal {
namespace {

// The kernel makes some kilobytes of it, its own bookkeeping included: half a dozen packets.
constexpr int kLeastBuffer_bytes = 1;

}  // namespace

void SocketCable::pump(ByteLine& device) {
  const int fd = is_out_ ? -1 : link_.connection(clock_.now());
  if (fd < 0) {
    std::array<std::uint8_t, 512> unheard;
    while (device.read(unheard) > 0) {
    }
    return;
  }
  if (link_.connections() != seen_connections_) {
    seen_connections_ = link_.connections();
    (void)::setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &kLeastBuffer_bytes, sizeof kLeastBuffer_bytes);
  }
  to_device(fd, device);
  if (link_.fd() >= 0) to_host(fd, device);
}

void SocketCable::to_device(int fd, ByteLine& device) {
  std::array<std::uint8_t, 512> bytes;
  for (;;) {
    const ssize_t count = ::read(fd, bytes.data(), bytes.size());
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {
      link_.hang_up(clock_.now());
      return;
    }
    const auto size = static_cast<std::size_t>(count);
    if (!device.write({bytes.data(), size})) lost_bytes_ += size;
    if (size < bytes.size()) return;
  }
}

void SocketCable::to_host(int fd, ByteLine& device) {
  std::array<std::uint8_t, 512> bytes;
  for (std::size_t size = device.read(bytes); size > 0; size = device.read(bytes)) {
    const ssize_t sent = ::send(fd, bytes.data(), size, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
      link_.hang_up(clock_.now());
      return;
    }
    lost_bytes_ += size - static_cast<std::size_t>(sent > 0 ? sent : 0);
  }
}

void SocketCable::pull_out() {
  is_out_ = true;
  link_.hang_up(clock_.now());
}

Result<void> SocketCable::plug_in() {
  is_out_ = false;
  return {};
}

}  // namespace g3d::hal
