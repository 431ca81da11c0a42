// SPDX-License-Identifier: Apache-2.0
// A robot as a service: what whoever started it hears, from the first frame in the map to the end.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <string>

#include "tests/support/run_program.hpp"
#include "tests/support/temp_folder.hpp"

using namespace g3d::test;

TEST_CASE("a robot says when it maps, what it does and that it stops", "[system][service]") {
  const TempFolder folder;
  const std::string name = "@g3dmap-service-test-" + std::to_string(::getpid());
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  REQUIRE(fd >= 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, name.data(), name.size());
  address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  REQUIRE(::bind(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0);

  // Longer than the socket's queue would be filled by: what is not read is lost, so it is read while it runs.
  write_plain(folder / "small.toml", "name = \"small\"\n[map]\nresolution_m = 0.1\nthreads = 1\nmemory_mb = 64\n");
  Program robot("/usr/bin/env", {"NOTIFY_SOCKET=" + name, "WATCHDOG_USEC=10000000", g3dmap_path(), "run", "--board",
                                 folder / "small.toml", "--world", "two_rooms", "--camera", "80x60@5", "--duration",
                                 "6", "--quiet", "--out", folder / "out"});
  std::string said;
  const auto listen = [&] {
    std::array<char, 1024> bytes;
    for (ssize_t n = 0; (n = ::recv(fd, bytes.data(), bytes.size(), 0)) >= 0;) {
      said.append(bytes.data(), static_cast<std::size_t>(n)).append("\n");
    }
  };
  for (int i = 0; i < 2000 && robot.is_running(); ++i) {
    listen();
    ::usleep(50'000);
  }
  const ProgramResult result = robot.finish();
  listen();
  ::close(fd);
  INFO(said << result.err);
  CHECK(result.exit_code == 0);
  const std::size_t ready = said.find("READY=1\n"), stopping = said.find("STOPPING=1\n");
  REQUIRE(ready != std::string::npos);
  REQUIRE(stopping != std::string::npos);
  CHECK(ready < stopping);
  CHECK(said.find("READY=1", ready + 1) == std::string::npos);
  CHECK_THAT(said.substr(ready, stopping - ready), Catch::Contains(" frames mapped, "));
  CHECK_THAT(said.substr(ready, stopping - ready), Catch::Contains("WATCHDOG=1\n"));
  CHECK_THAT(said.substr(0, stopping), Catch::Contains("WATCHDOG_USEC=90000000\n"));
  CHECK(stopping + std::string("STOPPING=1\n").size() == said.size());
}
