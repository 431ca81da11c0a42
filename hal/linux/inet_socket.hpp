// SPDX-License-Identifier: Apache-2.0
// What sockets of datagrams and of streams share: an endpoint as the kernel wants it, and what its errors mean to a
// person.
#pragma once

#include <netinet/in.h>

#include <string_view>

#include "hal/linux/ipv4_endpoint.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

[[nodiscard]] sockaddr_in system_address(const Ipv4Endpoint& endpoint);

/// "KIND 10.0.0.1:80: what: the system's words; remedy". `kind` may be empty.
[[nodiscard]] Error socket_error(std::string_view kind, const Ipv4Endpoint& at, const char* what, int error);

}  // namespace g3d::hal
