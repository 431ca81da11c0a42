// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/stream_link.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "hal/linux/inet_socket.hpp"

namespace g3d::hal {
namespace {

constexpr int kWaiting = 4;  // that have come and were not taken yet

std::optional<sockaddr_un> unix_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return std::nullopt;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

/// An open descriptor, or -1 and errno.
int dial_socket(int family, const sockaddr* address, socklen_t size) {
  const int fd = ::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  // TCP that is still on its way says so by its first read.
  if (::connect(fd, address, size) == 0 || errno == EINPROGRESS) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

int dial_path(const std::string& path) {
  struct stat there {};
  if (::stat(path.c_str(), &there) != 0) return -1;
  if (S_ISSOCK(there.st_mode)) {
    const auto address = unix_address(path);
    if (!address) {
      errno = ENAMETOOLONG;
      return -1;
    }
    return dial_socket(AF_UNIX, reinterpret_cast<const sockaddr*>(&*address), sizeof *address);
  }
  if (!S_ISCHR(there.st_mode) && !S_ISFIFO(there.st_mode)) {
    errno = ENOTSOCK;
    return -1;
  }
  return ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

int dial_place(const StreamPlace& place) {
  if (!place.is_tcp) return dial_path(place.path);
  const sockaddr_in address = system_address(place.endpoint);
  return dial_socket(AF_INET, reinterpret_cast<const sockaddr*>(&address), sizeof address);
}

Error listen_error(const StreamPlace& place, int error) {
  Reason reason = Reason::io_error;
  const char* remedy = "give another place";
  if (error == EADDRINUSE) {
    reason = Reason::no_capacity;
    remedy = "another program is there; end it, or give another place";
  } else if (error == EACCES || error == EPERM || error == EROFS) {
    reason = Reason::no_permission;
  }
  return {reason, fmt::format("{}: cannot listen: {}; {}", to_string(place), std::strerror(error), remedy)};
}

/// Removes a socket that nobody serves any more, and nothing else. False with errno.
bool clear_the_way(const std::string& path) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return true;
  errno = EADDRINUSE;
  if (!S_ISSOCK(there.st_mode)) return false;
  if (const int fd = dial_path(path); fd >= 0) {
    ::close(fd);
    errno = EADDRINUSE;
    return false;
  }
  return errno == ECONNREFUSED && ::unlink(path.c_str()) == 0;
}

/// Bound and listening, or -1 and errno.
int listener_at(StreamPlace& place) {
  const int fd = ::socket(place.is_tcp ? AF_INET : AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  bool is_bound = false;
  if (place.is_tcp) {
    const int one = 1;
    (void)::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one);
    const sockaddr_in address = system_address(place.endpoint);
    is_bound = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    sockaddr_in bound{};
    socklen_t size = sizeof bound;
    if (is_bound && ::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) == 0) {
      place.endpoint.port = ntohs(bound.sin_port);
    }
  } else if (const auto address = unix_address(place.path)) {
    is_bound =
        clear_the_way(place.path) && ::bind(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0;
  }
  if (is_bound && ::listen(fd, kWaiting) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

}  // namespace

Result<StreamPlace> parse_stream_place(std::string_view text) {
  StreamPlace place;
  if (text.starts_with("tcp:")) {
    const auto endpoint = parse_ipv4_endpoint(text.substr(4));
    place.is_tcp = true;
    if (endpoint) {
      place.endpoint = *endpoint;
      return place;
    }
  } else {
    place.path = text.starts_with("unix:") ? text.substr(5) : text;
    if (place.path.find('/') != std::string::npos && place.path.size() < sizeof(sockaddr_un::sun_path)) return place;
  }
  return Error{
      Reason::bad_usage,
      fmt::format("'{}': not tcp:ADDRESS:PORT, with the address in numbers, nor a path with a / and at most {} "
                  "bytes",
                  text, sizeof(sockaddr_un::sun_path) - 1)};
}

std::string to_string(const StreamPlace& place) {
  return place.is_tcp ? "tcp:" + to_string(place.endpoint) : place.path;
}

StreamLink StreamLink::dial(StreamPlace place, Pauses pauses) { return {std::move(place), pauses, -1}; }

Result<StreamLink> StreamLink::listen(StreamPlace place) {
  if (!place.is_tcp && !unix_address(place.path)) {
    return Error{Reason::too_large, fmt::format("{}: a socket's path has 1 to {} bytes; give a shorter one", place.path,
                                                sizeof(sockaddr_un::sun_path) - 1)};
  }
  const int listener = listener_at(place);
  if (listener < 0) return listen_error(place, errno);
  return StreamLink(std::move(place), {}, listener);
}

StreamLink::StreamLink(StreamLink&& other) noexcept
    : place_(std::move(other.place_)),
      pauses_(other.pauses_),
      listener_(std::exchange(other.listener_, -1)),
      fd_(std::exchange(other.fd_, -1)),
      pause_ns_(other.pause_ns_),
      next_try_ns_(other.next_try_ns_),
      connections_(other.connections_),
      last_errno_(other.last_errno_) {}

StreamLink::~StreamLink() {
  if (fd_ >= 0) ::close(fd_);
  if (listener_ < 0) return;
  ::close(listener_);
  if (!place_.is_tcp) (void)::unlink(place_.path.c_str());
}

int StreamLink::connection(TimeNs now_ns) {
  if (listener_ >= 0) {
    accept_newest();
    return fd_;
  }
  if (fd_ >= 0 || now_ns < next_try_ns_) return fd_;
  fd_ = dial_place(place_);
  if (fd_ >= 0) {
    last_errno_ = 0;
    ++connections_;
    return fd_;
  }
  last_errno_ = errno;
  next_try_ns_ = now_ns + pause_ns_;
  pause_ns_ = std::min(2 * pause_ns_, pauses_.most_ns);
  return fd_;
}

void StreamLink::accept_newest() {
  for (;;) {
    const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    if (place_.is_tcp) {
      const int one = 1;
      (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
    }
    if (fd_ >= 0) ::close(fd_);
    fd_ = fd;
    ++connections_;
  }
}

void StreamLink::hang_up(TimeNs now_ns) {
  if (fd_ < 0) return;
  ::close(std::exchange(fd_, -1));
  pause_ns_ = pauses_.first_ns;
  next_try_ns_ = now_ns + pause_ns_;
}

}  // namespace g3d::hal
