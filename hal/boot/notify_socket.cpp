// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/notify_socket.hpp"

#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>

#include "hal/image/atomic_file.hpp"

namespace g3d::hal::boot {

Result<std::unique_ptr<NotifySocket>> NotifySocket::open(const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path.size() >= sizeof name.sun_path) return Error{Reason::too_large, path + ": too long for a socket's name"};
  ::memcpy(name.sun_path, path.data(), path.size());
  (void)::unlink(path.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return system_error(path, "no socket", errno);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0 || ::chmod(path.c_str(), 0600) != 0) {
    const int problem = errno;
    ::close(fd);
    return system_error(path, "cannot be made", problem);
  }
  return std::unique_ptr<NotifySocket>(new NotifySocket(path, fd));
}

NotifySocket::~NotifySocket() {
  ::close(fd_);
  (void)::unlink(path_.c_str());
}

std::optional<Notice> NotifySocket::receive() {
  std::array<char, kMostNotice_bytes> bytes{};
  const ssize_t size = ::recv(fd_, bytes.data(), bytes.size(), 0);
  if (size < 0) return std::nullopt;
  return parse_notice({bytes.data(), static_cast<std::size_t>(size)});
}

}  // namespace g3d::hal::boot
