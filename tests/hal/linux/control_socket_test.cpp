// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/control_socket.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temp_folder.hpp"

using namespace g3d;
using hal::ControlSocket;
using hal::Reason;

namespace {

std::string echo(std::string_view request) { return "<" + std::string(request) + ">"; }

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

int connect_to(const std::string& path) {
  const sockaddr_un address = address_of(path);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

/// What a program leaves that was killed.
void leave_socket(const std::string& path) {
  const sockaddr_un address = address_of(path);
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  REQUIRE(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  ::close(fd);
}

std::string received(int fd) {
  std::array<char, 256> bytes;
  const ssize_t n = ::recv(fd, bytes.data(), bytes.size(), 0);
  return n > 0 ? std::string(bytes.data(), static_cast<std::size_t>(n)) : std::string{};
}

}  // namespace

TEST_CASE("one request, one answer, for its own user alone", "[threads]") {
  const test::TempFolder folder;
  const std::string path = folder / "control";
  {
    const auto socket = ControlSocket::open(path, echo);
    REQUIRE(socket.ok());
    struct stat info {};
    REQUIRE(::stat(path.c_str(), &info) == 0);
    CHECK((info.st_mode & 0777) == 0600);
    for (int i = 0; i < 20; ++i) CHECK(hal::ask_control_socket(path, "hello").value() == "<hello>");
    CHECK(hal::ask_control_socket(path, std::string(ControlSocket::kMostRequest_bytes, 'x')).value().size() ==
          ControlSocket::kMostRequest_bytes + 2);
    CHECK(socket.value()->counts().answered == 21);
    CHECK(socket.value()->counts().rejected() == 0);
  }
  CHECK(folder.listing().empty());
  CHECK(hal::ask_control_socket(path, "hello").error().reason == Reason::not_found);
}

TEST_CASE("a request that is too long is refused whole", "[threads]") {
  const test::TempFolder folder;
  const auto socket = ControlSocket::open(folder / "control", echo);
  REQUIRE(socket.ok());
  for (const std::size_t size : {ControlSocket::kMostRequest_bytes + 1, std::size_t{60'000}}) {
    const auto answer = hal::ask_control_socket(folder / "control", std::string(size, 'x'));
    REQUIRE(answer.ok());
    CHECK(answer.value().find("\"error\"") != std::string::npos);
  }
  CHECK(socket.value()->counts().too_long == 2);
  CHECK(socket.value()->counts().answered == 0);
}

TEST_CASE("who says nothing, hangs up or comes in a crowd keeps nobody else waiting for long", "[threads]") {
  const test::TempFolder folder;
  const std::string path = folder / "control";
  const auto socket = ControlSocket::open(path, echo);
  REQUIRE(socket.ok());
  std::vector<int> silent;
  for (std::size_t i = 0; i < ControlSocket::kMostClients; ++i) silent.push_back(connect_to(path));
  CHECK(silent.back() >= 0);
  ::close(silent.front());  // makes room at once
  std::string answer;
  for (int i = 0; i < 100 && answer.empty(); ++i) {
    const auto asked = hal::ask_control_socket(path, "hello");
    if (asked.ok()) answer = asked.value();
  }
  CHECK(answer == "<hello>");
  CHECK(received(silent[1]).empty());  // it was sent away after a second
  for (std::size_t i = 1; i < silent.size(); ++i) ::close(silent[i]);
  CHECK(hal::ask_control_socket(path, "again").value() == "<again>");
  CHECK(socket.value()->counts().too_slow > 0);
}

TEST_CASE("a socket that a killed program left is replaced, a living one's and other files are not", "[threads]") {
  const test::TempFolder folder;
  const std::string path = folder / "control";
  leave_socket(path);
  CHECK(hal::ask_control_socket(path, "hello").error().reason == Reason::no_capacity);
  const auto first = ControlSocket::open(path, echo);
  REQUIRE(first.ok());
  const auto second = ControlSocket::open(path, echo);
  REQUIRE_FALSE(second.ok());
  CHECK(second.error().reason == Reason::no_capacity);
  CHECK(second.error().text.find("another robot runs here") != std::string::npos);
  CHECK(hal::ask_control_socket(path, "hello").value() == "<hello>");

  test::write_plain(folder / "notes", "mine");
  const auto third = ControlSocket::open(folder / "notes", echo);
  REQUIRE_FALSE(third.ok());
  CHECK(third.error().reason == Reason::no_permission);
  CHECK(test::read_plain(folder / "notes") == "mine");
}

TEST_CASE("paths that cannot be a socket are said, with what to do") {
  const test::TempFolder folder;
  CHECK(ControlSocket::open(std::string(200, 'x'), echo).error().reason == Reason::too_large);
  CHECK(ControlSocket::open("", echo).error().reason == Reason::too_large);
  CHECK(ControlSocket::open(folder.path() + "/no/such/control", echo).error().reason == Reason::not_found);
  CHECK(hal::ask_control_socket(std::string(200, 'x'), "status").error().reason == Reason::too_large);
}
