// SPDX-License-Identifier: Apache-2.0
// A few GPIO lines of one chip: inputs whose edges the kernel stamps, and perhaps one output. Behind it stands the
// kernel's character device (linux/gpio_chip.hpp) or a test.
#pragma once

#include <cstdint>
#include <optional>

#include "hal/messages.hpp"

namespace g3d::hal {

inline constexpr std::size_t kMaxGpioInputs = 2;

struct GpioEdge {
  TimeNs t_ns = 0;  ///< of the edge, by the kernel, on our clock
  std::uint8_t input = 0;
  bool level = false;  ///< after it
  bool operator==(const GpioEdge&) const = default;
};

struct GpioCounts {
  std::uint64_t edges = 0;
  std::uint64_t failed_reads = 0;   ///< of edges or levels: the chip is gone, or does not answer
  std::uint64_t failed_writes = 0;  ///< of the output
  std::uint64_t bad_stamps = 0;     ///< edges whose stamp was on no clock that we know; taken for now
};

class GpioLines {
 public:
  virtual ~GpioLines() = default;
  /// How many inputs there are, 1 or 2.
  [[nodiscard]] virtual std::size_t input_count() const = 0;
  /// The next edge that has not been read; false: none. Never waits. One thread, as all that follows.
  [[nodiscard]] virtual bool read_edge(GpioEdge& edge, TimeNs now_ns) = 0;
  /// The level at this moment; nothing: it cannot be read.
  [[nodiscard]] virtual std::optional<bool> level(std::size_t input) = 0;
  /// Without an output nothing happens.
  virtual void set_output(bool level) = 0;
  [[nodiscard]] virtual const GpioCounts& counts() const = 0;
};

}  // namespace g3d::hal
