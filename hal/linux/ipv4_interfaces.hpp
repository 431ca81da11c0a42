// SPDX-License-Identifier: Apache-2.0
// Which network interfaces there are now that have an IPv4 address. Into fixed memory: a radio is looked for again
// every second while the robot drives. Plain.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace g3d::hal {

struct Ipv4Interface {
  std::array<char, 16> name{};  ///< ends with 0
  int index = 0;                ///< as the kernel counts them; a new one whenever an interface comes back
  std::uint32_t ipv4 = 0;       ///< its first address
  bool is_running = false;      ///< up, and what it hangs on is there: cable, access point
  bool has_multicast = false;
  bool is_loopback = false;
  [[nodiscard]] std::string_view text() const { return name.data(); }
};

struct Ipv4Interfaces {
  static constexpr std::size_t kMost = 16;
  std::array<Ipv4Interface, kMost> list;
  std::size_t count = 0;
  [[nodiscard]] std::span<const Ipv4Interface> all() const { return {list.data(), count}; }
};

/// `fd`: any IPv4 socket. Of more than kMost the first; none if the system does not say.
[[nodiscard]] Ipv4Interfaces list_ipv4_interfaces(int fd);

}  // namespace g3d::hal
