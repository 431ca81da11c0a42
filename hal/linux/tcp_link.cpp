// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/tcp_link.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "hal/linux/inet_socket.hpp"

namespace g3d::hal {
namespace {

constexpr int kWaitingConnections = 8;

const sockaddr* general(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }

Error tcp_error(const Ipv4Endpoint& at, const char* what, int error) { return socket_error("", at, what, error); }

bool is_only_late(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

void set_low_delay(int fd) {
  const int on = 1;
  (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

}  // namespace

Result<TcpLink> TcpLink::connect(const Ipv4Endpoint& to, int patience_ms) {
  TcpLink link(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!link.is_open()) return tcp_error(to, "no socket", errno);
  const sockaddr_in address = system_address(to);
  int failed = ::connect(link.fd_, general(address), sizeof address) == 0 ? 0 : errno;
  if (failed == EINPROGRESS || failed == EINTR) {
    if (!link.wait(POLLOUT, patience_ms)) return tcp_error(to, "cannot connect", ETIMEDOUT);
    socklen_t size = sizeof failed;
    if (::getsockopt(link.fd_, SOL_SOCKET, SO_ERROR, &failed, &size) != 0) failed = errno;
  }
  if (failed != 0) return tcp_error(to, "cannot connect", failed);
  set_low_delay(link.fd_);
  return link;
}

TcpLink& TcpLink::operator=(TcpLink&& other) noexcept {
  if (this != &other) {
    close();
    fd_ = std::exchange(other.fd_, -1);
  }
  return *this;
}

TcpLink::~TcpLink() { close(); }

void TcpLink::close() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

void TcpLink::say_no_more() { (void)::shutdown(fd_, SHUT_WR); }

TcpLink::Outcome TcpLink::receive(std::span<std::uint8_t> bytes, std::size_t& count) {
  count = 0;
  const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
  if (n < 0) return is_only_late(errno) ? Outcome::not_yet : Outcome::over;
  if (n == 0) return bytes.empty() ? Outcome::done : Outcome::over;
  count = static_cast<std::size_t>(n);
  return Outcome::done;
}

TcpLink::Outcome TcpLink::send(std::span<const std::uint8_t> bytes, std::size_t& count) {
  count = 0;
  const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  if (n < 0) return is_only_late(errno) ? Outcome::not_yet : Outcome::over;
  count = static_cast<std::size_t>(n);
  return Outcome::done;
}

bool TcpLink::wait(short events, int patience_ms) const {
  pollfd one{fd_, events, 0};
  for (;;) {
    const int ready = ::poll(&one, 1, patience_ms);
    if (ready < 0 && errno == EINTR) continue;
    return ready == 1;
  }
}

bool TcpLink::receive_all(std::span<std::uint8_t> bytes, int patience_ms) {
  while (!bytes.empty()) {
    std::size_t count = 0;
    const Outcome outcome = receive(bytes, count);
    if (outcome == Outcome::over || (outcome == Outcome::not_yet && !wait(POLLIN, patience_ms))) return false;
    bytes = bytes.subspan(count);
  }
  return true;
}

bool TcpLink::send_all(std::span<const std::uint8_t> bytes, int patience_ms) {
  while (!bytes.empty()) {
    std::size_t count = 0;
    const Outcome outcome = send(bytes, count);
    if (outcome == Outcome::over || (outcome == Outcome::not_yet && !wait(POLLOUT, patience_ms))) return false;
    bytes = bytes.subspan(count);
  }
  return true;
}

Result<TcpListener> TcpListener::open(const Ipv4Endpoint& at) {
  TcpListener listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), at);
  if (listener.fd_ < 0) return tcp_error(at, "no socket", errno);
  const int on = 1;
  // Else a listener that starts again would wait a minute for old connections to be forgotten.
  (void)::setsockopt(listener.fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address = system_address(at);
  socklen_t size = sizeof address;
  if (::bind(listener.fd_, general(address), size) != 0 || ::listen(listener.fd_, kWaitingConnections) != 0 ||
      ::getsockname(listener.fd_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return tcp_error(at, "cannot listen", errno);
  }
  listener.at_.port = ntohs(address.sin_port);
  return listener;
}

TcpListener::~TcpListener() {
  if (fd_ >= 0) ::close(fd_);
}

std::optional<TcpLink> TcpListener::accept(Ipv4Endpoint& from) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  const int fd = ::accept4(fd_, reinterpret_cast<sockaddr*>(&address), &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return std::nullopt;
  from = {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
  set_low_delay(fd);
  return TcpLink(fd);
}

}  // namespace g3d::hal
