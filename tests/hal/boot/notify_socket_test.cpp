// SPDX-License-Identifier: Apache-2.0
#include "hal/boot/notify_socket.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::boot::NotifySocket;

TEST_CASE("what a process notifies is received, one datagram at a time", "[boot]") {
  const test::TempFolder folder;
  const std::string path = folder.path() + "/notify";
  auto socket = NotifySocket::open(path);
  REQUIRE(socket.ok());
  CHECK_FALSE(socket.value()->receive());

  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, path.data(), path.size());
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto send = [&](const std::string& text) {
    return ::sendto(fd, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&name), sizeof name);
  };
  CHECK(send("READY=1\n") == 8);
  CHECK(send("STATUS=x") == 8);
  const auto first = socket.value()->receive();
  REQUIRE(first);
  CHECK(first->is_ready);
  const auto second = socket.value()->receive();
  REQUIRE(second);
  CHECK(second->status == "x");
  CHECK_FALSE(second->is_ready);
  CHECK_FALSE(socket.value()->receive());
  socket.value().reset();
  CHECK(send("READY=1") == -1);  // nobody is there any more
  ::close(fd);
}

TEST_CASE("a socket that a killed program left is replaced, a path that is too long refused", "[boot]") {
  const test::TempFolder folder;
  test::write_plain(folder / "notify", "left over");
  CHECK(NotifySocket::open(folder / "notify").ok());
  CHECK(NotifySocket::open("/" + std::string(200, 'x')).error().reason == hal::Reason::too_large);
  CHECK_FALSE(NotifySocket::open(folder.path() + "/none/notify").ok());
}
