// SPDX-License-Identifier: Apache-2.0
// What a robot is called when nobody has given it a name: the same after every start, another one on every machine. Two
// robots on one machine need names of their own. Cold paths only.
#pragma once

#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "net/layer_id.hpp"

namespace g3d::net {

/// Where a machine says what it is called. The machine's own id is not told to anybody: it goes through a hash.
struct MachineFiles {
  std::string machine_id = "/etc/machine-id";
  std::string interfaces = "/sys/class/net";  ///< folders with a file "address" in each
};

/// Never 0. From the machine's id; without one, from the lowest hardware address of its network interfaces. Errors:
/// not_found, if there is neither.
[[nodiscard]] hal::Result<RobotId> machine_robot_id(const MachineFiles& files = {});

/// For a layer whose counter of versions begins anew: one that nobody has used, but for a chance of one in four billion
/// per earlier start of this robot. Never 0.
[[nodiscard]] std::uint32_t fresh_incarnation();

/// 16 hexadecimal digits, as `g3dmap key --revoke` takes them.
[[nodiscard]] std::string text_of_robot(RobotId robot);
/// The same, a point and 8 digits.
[[nodiscard]] std::string text_of_layer(const LayerId& layer);

}  // namespace g3d::net
