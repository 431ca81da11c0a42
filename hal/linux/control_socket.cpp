// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/control_socket.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace g3d::hal {
namespace {

constexpr int kPatience_ms = 1000;

std::int64_t now_ms() {
  timespec now{};
  (void)::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

Result<sockaddr_un> address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    return Error{Reason::too_large, fmt::format("{}: a socket's path has 1 to {} bytes; give a shorter one", path,
                                                sizeof address.sun_path - 1)};
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

Error socket_error(const std::string& path, const char* what, int error) {
  Reason reason = Reason::io_error;
  const char* remedy = "give another path";
  if (error == ENOENT || error == ENOTDIR) {
    reason = Reason::not_found;
    remedy = "is a robot running there? Its folder, or its --control, is the path to give";
  } else if (error == EACCES || error == EPERM || error == EROFS) {
    reason = Reason::no_permission;
    remedy = "only the user who started the robot may speak to it";
  } else if (error == ECONNREFUSED) {
    reason = Reason::no_capacity;
    remedy = "the robot that was there has ended";
  }
  return {reason, fmt::format("{}: {}: {}; {}", path, what, std::strerror(error), remedy)};
}

const sockaddr* plain(const sockaddr_un& address) { return reinterpret_cast<const sockaddr*>(&address); }

/// A connection, or -1 and errno.
int connect_to(const sockaddr_un& address) {
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (::connect(fd, plain(address), sizeof address) == 0) return fd;
  const int error = errno;
  ::close(fd);
  errno = error;
  return -1;
}

/// Makes room for a new socket: what a killed program left is removed, nothing else.
Result<void> clear_the_way(const std::string& path, const sockaddr_un& address) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return {};
  if (!S_ISSOCK(there.st_mode)) {
    return Error{Reason::no_permission,
                 fmt::format("{}: is there already and is no socket; remove it or give another --control", path)};
  }
  if (const int fd = connect_to(address); fd >= 0) {
    ::close(fd);
    return Error{Reason::no_capacity,
                 fmt::format("{}: another robot runs here; end it, or give another --out or --control", path)};
  }
  if (errno != ECONNREFUSED) return socket_error(path, "cannot be replaced", errno);
  (void)::unlink(path.c_str());
  return {};
}

}  // namespace

Result<std::unique_ptr<ControlSocket>> ControlSocket::open(const std::string& path, Answer answer) {
  const auto address = address_of(path);
  if (!address) return address.error();
  if (const auto clear = clear_the_way(path, address.value()); !clear) return clear.error();
  const int listener = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener < 0) return socket_error(path, "no socket", errno);
  // Nobody can connect before listen(), so nobody gets in before the permissions are right.
  if (::bind(listener, plain(address.value()), sizeof(sockaddr_un)) != 0 || ::chmod(path.c_str(), 0600) != 0 ||
      ::listen(listener, static_cast<int>(kMostClients)) != 0) {
    const Error error = socket_error(path, "cannot be made", errno);
    ::close(listener);
    return error;
  }
  const int wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake < 0) {
    const Error error = socket_error(path, "no event", errno);
    ::close(listener);
    return error;
  }
  return std::unique_ptr<ControlSocket>(new ControlSocket(path, listener, wake, std::move(answer)));
}

ControlSocket::ControlSocket(std::string path, int listener, int wake, Answer answer)
    : path_(std::move(path)), listener_(listener), wake_(wake), answer_(std::move(answer)), thread_([this] {
        serve();
      }) {}

ControlSocket::~ControlSocket() {
  const std::uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
  thread_.join();
  (void)::unlink(path_.c_str());
  ::close(listener_);
  ::close(wake_);
}

ControlCounts ControlSocket::counts() const {
  return {answered_.load(std::memory_order_relaxed), too_long_.load(std::memory_order_relaxed),
          too_slow_.load(std::memory_order_relaxed), too_many_.load(std::memory_order_relaxed)};
}

void ControlSocket::serve() {
  (void)::pthread_setname_np(::pthread_self(), "control");
  std::array<Client, kMostClients> clients;
  for (;;) {
    std::array<pollfd, kMostClients + 2> waits{};
    waits[0] = {wake_, POLLIN, 0};
    waits[1] = {listener_, POLLIN, 0};
    for (std::size_t i = 0; i < kMostClients; ++i) waits[i + 2] = {clients[i].fd, POLLIN, 0};  // -1 is passed over
    if (::poll(waits.data(), waits.size(), kPatience_ms / 4) < 0 && errno != EINTR) break;
    if (waits[0].revents != 0) break;
    const std::int64_t now = now_ms();
    for (std::size_t i = 0; i < kMostClients; ++i) {
      Client& client = clients[i];
      if (client.fd < 0) continue;
      const bool is_late = now >= client.until_ms;
      const bool has_said = waits[i + 2].revents != 0;
      if (!has_said && !is_late) continue;
      if (has_said ? !serve_one(client.fd) : is_late) too_slow_.fetch_add(1, std::memory_order_relaxed);
      ::close(std::exchange(client.fd, -1));
    }
    if (waits[1].revents != 0) accept_one(clients);
  }
  for (const Client& client : clients) {
    if (client.fd >= 0) ::close(client.fd);
  }
}

void ControlSocket::accept_one(std::array<Client, kMostClients>& clients) {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  for (Client& client : clients) {
    if (client.fd >= 0) continue;
    client = {fd, now_ms() + kPatience_ms};
    return;
  }
  too_many_.fetch_add(1, std::memory_order_relaxed);
  ::close(fd);
}

/// False if nothing came, or the answer was not taken.
bool ControlSocket::serve_one(int fd) {
  std::array<char, kMostRequest_bytes> request;
  const ssize_t size = ::recv(fd, request.data(), request.size(), MSG_TRUNC);  // the message's whole size
  if (size <= 0) return false;
  std::string answer;
  if (static_cast<std::size_t>(size) > request.size()) {
    too_long_.fetch_add(1, std::memory_order_relaxed);
    answer = "{\"error\": \"the request is too long\"}\n";
  } else {
    answer = answer_({request.data(), static_cast<std::size_t>(size)});
    answered_.fetch_add(1, std::memory_order_relaxed);
  }
  return ::send(fd, answer.data(), answer.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(answer.size());
}

Result<std::string> ask_control_socket(const std::string& path, std::string_view request, int patience_ms) {
  const auto address = address_of(path);
  if (!address) return address.error();
  const int fd = connect_to(address.value());
  if (fd < 0) return socket_error(path, "nobody answers", errno);
  std::string answer(ControlSocket::kMostAnswer_bytes, '\0');
  const bool is_sent = ::send(fd, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size());
  pollfd wait{fd, POLLIN, 0};
  const bool is_there = is_sent && ::poll(&wait, 1, patience_ms) == 1;
  const ssize_t size = is_there ? ::recv(fd, answer.data(), answer.size(), 0) : 0;
  ::close(fd);
  if (size <= 0) {
    return Error{Reason::io_error,
                 fmt::format("{}: the robot did not answer; try again, or see whether it still runs", path)};
  }
  answer.resize(static_cast<std::size_t>(size));
  return answer;
}

}  // namespace g3d::hal
