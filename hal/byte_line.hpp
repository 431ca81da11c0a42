// SPDX-License-Identifier: Apache-2.0
// A line of bytes to a device: a serial port, a pseudo-terminal, a recording, or a simulated base in the same process.
// Never blocks: a line without data returns 0, a lost line says so and may come back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace g3d::hal {

enum class LineState { up, lost };

class ByteLine {
 public:
  virtual ~ByteLine() = default;
  /// Reads what is there, at most `into.size()` bytes; 0 if nothing is.
  [[nodiscard]] virtual std::size_t read(std::span<std::uint8_t> into) = 0;
  /// Writes all or, if the line is lost or full, nothing. Returns whether it did.
  [[nodiscard]] virtual bool write(std::span<const std::uint8_t> bytes) = 0;
  [[nodiscard]] virtual LineState state() const = 0;
};

}  // namespace g3d::hal
