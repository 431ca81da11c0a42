// SPDX-License-Identifier: Apache-2.0
// What `ip link` does with CAN interfaces, for a robot that has no such program: bit rate, up, restart after bus-off,
// and virtual ones for tests; through rtnetlink. Takes CAP_NET_ADMIN. May wait for the kernel: not for the base's
// thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/result.hpp"

namespace g3d::hal {

/// One RTM_NEWLINK request.
struct CanLinkRequest {
  std::string interface;
  int index = 0;  ///< of the interface; 0: by name
  bool creates = false;
  std::optional<bool> is_up;
  std::string kind;                         ///< "can" or "vcan": needed with what follows, and to create
  std::optional<std::uint32_t> bitrate;     ///< bit/s; the link must be down
  std::optional<std::uint32_t> restart_ms;  ///< the kernel restarts the controller itself after so long; 0: not
  bool restarts = false;                    ///< now
};
/// The netlink message, header included.
[[nodiscard]] std::vector<std::uint8_t> encode_link_request(const CanLinkRequest& request, std::uint32_t sequence);
/// Sends it and waits for the answer. Errors: not_found, no_permission, unsupported, io_error; with the remedy.
[[nodiscard]] Result<void> ask_for_link(const CanLinkRequest& request);

/// Up, at `bitrate` bit/s (0: as it is), so that the kernel does not restart it by itself: we do, with a back-off.
[[nodiscard]] Result<void> bring_can_up(const std::string& interface, std::uint32_t bitrate);
/// Whether it is there and up.
[[nodiscard]] bool link_is_up(const std::string& interface);
/// After bus-off.
[[nodiscard]] Result<void> restart_can(const std::string& interface);
/// A virtual interface, up; good if it is there already.
[[nodiscard]] Result<void> make_virtual_can(const std::string& interface);

}  // namespace g3d::hal
