// SPDX-License-Identifier: Apache-2.0
#include "hal/linux/inet_socket.hpp"

#include <fmt/format.h>
#include <string.h>

#include <cerrno>

namespace g3d::hal {
namespace {

struct SocketAdvice {
  Reason reason = Reason::io_error;
  const char* remedy = "see whether this machine and the other one have a network";
};

SocketAdvice socket_advice(int error) {
  switch (error) {
    case EADDRINUSE:
      return {Reason::no_capacity, "another program listens there; end it, or give another port"};
    case EACCES:
    case EPERM:
      return {Reason::no_permission, "ports below 1024 are for root; give another one"};
    case EADDRNOTAVAIL:
      return {Reason::not_found, "this machine does not have that address; give 0.0.0.0 for all that it has"};
    case ECONNREFUSED:
      return {Reason::not_found, "the machine is there, but nothing listens at that port"};
    case EHOSTUNREACH:
    case ENETUNREACH:
      return {Reason::not_found, "there is no way to that address; check it, and whether the machine is on"};
    case ETIMEDOUT:
      return {Reason::io_error, "nobody answers at that address; check it, and whether the machine is on"};
    default:
      return {};
  }
}

}  // namespace

sockaddr_in system_address(const Ipv4Endpoint& endpoint) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(endpoint.ipv4);
  address.sin_port = htons(endpoint.port);
  return address;
}

Error socket_error(std::string_view kind, const Ipv4Endpoint& at, const char* what, int error) {
  const SocketAdvice advice = socket_advice(error);
  const char* const words = ::strerrordesc_np(error);
  return {advice.reason, fmt::format("{}{}{}: {}: {}; {}", kind, kind.empty() ? "" : " ", to_string(at), what,
                                     words != nullptr ? words : "failed", advice.remedy)};
}

}  // namespace g3d::hal
