// SPDX-License-Identifier: Apache-2.0
// The other end of a simulated base's cable, where a program that drives real robots finds it. Whoever runs the base
// moves the bytes by calling pump() every millisecond or two.
#pragma once

#include <cstdint>
#include <string>

#include "hal/byte_line.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

class BaseCable {
 public:
  virtual ~BaseCable() = default;
  /// Where the host finds it now; empty while unplugged.
  [[nodiscard]] virtual std::string path() const = 0;
  /// What the host wrote goes to the device, what the device says to the host. Never blocks; what the host does not
  /// take in time is lost and counted.
  virtual void pump(ByteLine& device) = 0;
  /// Bytes that a host which is there did not take, or the device did not.
  [[nodiscard]] virtual std::uint64_t lost_bytes() const = 0;
  /// The host sees its port vanish.
  virtual void pull_out() = 0;
  [[nodiscard]] virtual Result<void> plug_in() = 0;
  /// How often a host came; a terminal does not know.
  [[nodiscard]] virtual std::uint64_t connections() const { return 0; }
  [[nodiscard]] virtual bool is_connected() const { return true; }
};

}  // namespace g3d::hal
