// SPDX-License-Identifier: Apache-2.0
// GPIO lines of the kernel's character device, through libgpiod 1.6 (its first interface, which kernel 4.9 has too).
#pragma once

#include <array>
#include <memory>
#include <string>

#include "hal/gpio/gpio_lines.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

struct GpioChipOptions {
  std::string chip;                                ///< "gpiochip0", its label, or its path
  std::array<std::string, kMaxGpioInputs> inputs;  ///< names or numbers; an empty one is none
  std::string output;                              ///< the same
  std::string bias =
      "as_is";  ///< of the inputs: "as_is", "pull_up", "pull_down", "disable"; others than as_is: Linux 5.5
};

/// The kernel's stamp of an edge on CLOCK_MONOTONIC: Linux 5.7 and later stamp with that clock, earlier ones with
/// CLOCK_REALTIME. Nothing: it is near to neither's now.
[[nodiscard]] std::optional<TimeNs> monotonic_edge_ns(TimeNs stamp_ns, TimeNs monotonic_now_ns, TimeNs real_now_ns);

class GpioChip final : public GpioLines {
 public:
  /// Errors: not_found (no chip or line of that name), no_permission, no_capacity (a line is in use), unsupported,
  /// io_error.
  [[nodiscard]] static Result<std::unique_ptr<GpioChip>> open(const GpioChipOptions& options);
  ~GpioChip() override;
  GpioChip(const GpioChip&) = delete;
  GpioChip& operator=(const GpioChip&) = delete;

  [[nodiscard]] std::size_t input_count() const override;
  [[nodiscard]] bool read_edge(GpioEdge& edge, TimeNs now_ns) override;
  [[nodiscard]] std::optional<bool> level(std::size_t input) override;
  void set_output(bool level) override;
  [[nodiscard]] const GpioCounts& counts() const override { return counts_; }

 private:
  struct Lines;
  explicit GpioChip(std::unique_ptr<Lines> lines);
  [[nodiscard]] bool fill(std::size_t input);

  const std::unique_ptr<Lines> lines_;
  GpioCounts counts_;
};

}  // namespace g3d::hal
