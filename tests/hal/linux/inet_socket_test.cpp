// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/inet_socket.hpp"

#include <catch2/catch.hpp>
#include <cerrno>

using namespace g3d::hal;

TEST_CASE("an endpoint is given to the kernel in the network's order of bytes") {
  const sockaddr_in address = system_address({0x0A000102, 7177});
  CHECK(address.sin_family == AF_INET);
  const auto* bytes = reinterpret_cast<const unsigned char*>(&address.sin_addr.s_addr);
  CHECK((bytes[0] == 10 && bytes[1] == 0 && bytes[2] == 1 && bytes[3] == 2));
  CHECK(ntohs(address.sin_port) == 7177);
}

TEST_CASE("a socket's error names the place, what was tried, and what can be done") {
  const Ipv4Endpoint at{0x0A000102, 80};
  const Error in_use = socket_error("udp", at, "cannot listen", EADDRINUSE);
  CHECK(in_use.reason == Reason::no_capacity);
  CHECK(
      in_use.text ==
      "udp 10.0.1.2:80: cannot listen: Address already in use; another program listens there; end it, or give another "
      "port");
  CHECK(socket_error("", at, "cannot listen", EACCES).text.starts_with("10.0.1.2:80: cannot listen: "));
  CHECK(socket_error("", at, "x", EACCES).reason == Reason::no_permission);
  for (const int error : {EADDRNOTAVAIL, ECONNREFUSED, EHOSTUNREACH, ENETUNREACH}) {
    CHECK(socket_error("", at, "x", error).reason == Reason::not_found);
  }
  for (const int error : {ETIMEDOUT, ENOPROTOOPT, 99999}) {
    const Error other = socket_error("", at, "x", error);
    CHECK(other.reason == Reason::io_error);
    CHECK(other.text.find("; ") != std::string::npos);
  }
}
