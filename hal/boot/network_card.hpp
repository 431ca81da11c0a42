// SPDX-License-Identifier: Apache-2.0
// The network cards of a machine without anybody else who looks after them: found, switched on, given an address.
// Through ioctl, as that is all it takes for one IPv4 address. Plain; one thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/boot/link_local.hpp"
#include "hal/result.hpp"

namespace g3d::hal::boot {

/// Names of all Ethernet cards, real ones and virtual ones, sorted. `net_folder`: /sys/class/net.
[[nodiscard]] std::vector<std::string> ethernet_cards(const std::string& net_folder = "/sys/class/net");

/// Up, without an address yet; also "lo", and a CAN bus. Errors: not_found, no_permission, io_error.
[[nodiscard]] Result<void> switch_on(const std::string& card);
/// Host byte order. Errors: as above.
[[nodiscard]] Result<void> set_address(const std::string& card, std::uint32_t ipv4, int prefix_bits);
[[nodiscard]] Result<void> set_gateway(std::uint32_t ipv4);
[[nodiscard]] std::optional<MacAddress> mac_of(const std::string& card);
[[nodiscard]] int index_of(const std::string& card);

/// A CAN bus in memory, "vcan0", where there is none: for machines that are emulated. Errors: as above.
[[nodiscard]] Result<void> make_virtual_can(const std::string& name);

}  // namespace g3d::hal::boot
