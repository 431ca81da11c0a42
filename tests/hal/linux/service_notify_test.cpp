// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/service_notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::ServiceNotify;

namespace {

/// What systemd has at the other end.
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& name)
      : fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name[0] == '@') address.sun_path[0] = '\0';
    const std::size_t size = offsetof(sockaddr_un, sun_path) + name.size() + (name[0] == '@' ? 0 : 1);
    REQUIRE(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(size)) == 0);
  }
  ~NotifySocket() { ::close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;
  std::string next() const {
    std::array<char, 2048> bytes;
    const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
    return n >= 0 ? std::string(bytes.data(), static_cast<std::size_t>(n)) : std::string("nothing");
  }

 private:
  int fd_;
};

std::string abstract_name() { return "@g3dmap-notify-test-" + std::to_string(::getpid()); }

}  // namespace

TEST_CASE("whoever supervises hears every word, by a path or by an abstract name") {
  const test::TempFolder folder;
  for (const std::string& name : {folder / "notify", abstract_name()}) {
    const NotifySocket socket(name);
    ServiceNotify notify(name, "3000000");
    CHECK(notify.is_supervised());
    CHECK(notify.alive_period_ns() == 1'500 * hal::kMillisecond_ns);
    CHECK(notify.ready());
    CHECK(notify.alive());
    CHECK(notify.status("12 % seen"));
    CHECK(notify.stopping());
    CHECK(socket.next() == "READY=1");
    CHECK(socket.next() == "WATCHDOG=1");
    CHECK(socket.next() == "STATUS=12 % seen");
    CHECK(socket.next() == "STOPPING=1");
    CHECK(socket.next() == "nothing");
    CHECK(notify.sent() == 4);
    CHECK(notify.lost() == 0);
  }
}

TEST_CASE("a status is one line of bounded length, whatever is in it") {
  const std::string name = abstract_name();
  const NotifySocket socket(name);
  ServiceNotify notify(name, "");
  CHECK(notify.status("a\nREADY=1\r\t\x01z"));
  CHECK(socket.next() == "STATUS=a READY=1   z");
  CHECK(notify.status(std::string(5000, 'x')));
  CHECK(socket.next() == "STATUS=" + std::string(ServiceNotify::kMostStatus_bytes, 'x'));
  CHECK(notify.status(""));
  CHECK(socket.next() == "STATUS=");
}

TEST_CASE("without a supervisor, or with a wrong address, nothing is said") {
  const test::TempFolder folder;
  for (const std::string& name : {std::string(), std::string("@"), std::string("/"), std::string("relative"),
                                  folder / "none", std::string(200, '/'), std::string("vsock:1:2")}) {
    ServiceNotify notify(name, "1000000");
    INFO(name);
    CHECK_FALSE(notify.is_supervised());
    CHECK(notify.alive_period_ns() == 0);
    CHECK_FALSE(notify.ready());
    CHECK(notify.lost() == 0);
  }
}

TEST_CASE("a supervisor that is gone, or does not listen, costs a count and no time") {
  const std::string name = abstract_name();
  auto socket = std::make_unique<NotifySocket>(name);
  ServiceNotify notify(name, "");
  int taken = 0;
  while (notify.alive()) ++taken;  // until its queue is full
  CHECK(taken > 0);
  CHECK(notify.lost() == 1);
  socket.reset();
  CHECK_FALSE(notify.alive());
  CHECK(notify.lost() == 2);
}

TEST_CASE("work that takes long is allowed silence, where somebody counts") {
  const std::string name = abstract_name();
  const NotifySocket socket(name);
  ServiceNotify watched(name, "1000000"), unwatched(name, "");
  CHECK(watched.allow_silence(90'000 * hal::kMillisecond_ns));
  CHECK(socket.next() == "WATCHDOG_USEC=90000000");
  CHECK(watched.allow_silence(0));  // 0 would mean that nobody watches any more
  CHECK(socket.next() == "WATCHDOG_USEC=1");
  CHECK_FALSE(unwatched.allow_silence(1'000 * hal::kMillisecond_ns));
  CHECK(socket.next() == "nothing");
}

TEST_CASE("only a sensible watchdog that is meant for this process counts") {
  const std::string name = abstract_name();
  const NotifySocket socket(name);
  const std::string self = std::to_string(::getpid());
  CHECK(ServiceNotify(name, "10000000", self).alive_period_ns() == 5'000 * hal::kMillisecond_ns);
  CHECK(ServiceNotify(name, "10000000", "1").alive_period_ns() == 0);
  for (const char* wrong : {"", "0", "-1", "1s", " 1", "99999999999999999999", "86400000001"}) {
    CHECK(ServiceNotify(name, wrong).alive_period_ns() == 0);
  }
}

TEST_CASE("the environment names the socket") {
  const std::string name = abstract_name();
  const NotifySocket socket(name);
  REQUIRE(::setenv("NOTIFY_SOCKET", name.c_str(), 1) == 0);
  REQUIRE(::setenv("WATCHDOG_USEC", "2000000", 1) == 0);
  {
    ServiceNotify notify;
    CHECK(notify.is_supervised());
    CHECK(notify.alive_period_ns() == 1'000 * hal::kMillisecond_ns);
  }
  REQUIRE(::unsetenv("NOTIFY_SOCKET") == 0);
  REQUIRE(::unsetenv("WATCHDOG_USEC") == 0);
  CHECK_FALSE(ServiceNotify().is_supervised());
}
