// SPDX-License-Identifier: Apache-2.0
// `gpio.log`: `t_ns line value`, one edge in each line: nanoseconds of the log's clock, the line's name, 0 or 1. A
// process that was killed may leave half a line at the end, which is no error. And lines that change as it says.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/gpio/gpio_lines.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

inline constexpr std::size_t kMaxGpioLog_bytes = std::size_t{1} << 26;
inline constexpr std::size_t kMaxGpioName = 63;
inline constexpr std::size_t kMaxGpioLogLine = 88;

struct GpioRecord {
  TimeNs t_ns = 0;
  std::string line;
  bool level = false;
  bool operator==(const GpioRecord&) const = default;
};

struct GpioLog {
  std::vector<GpioRecord> records;  ///< in the order of time
  std::size_t torn_bytes = 0;       ///< of half a line at the end, dropped
};

/// A line's name as it may stand in a log: 1 to 63 printable characters without a space.
[[nodiscard]] bool is_gpio_name(std::string_view text);
/// The line with its newline into `out`, which has room for kMaxGpioLogLine; returns its length. Allocates nothing.
std::size_t format_gpio_line_to(char* out, TimeNs t_ns, std::string_view name, bool level);

/// Checks the whole file. Errors: what read_file says; malformed, with file, line and reason.
[[nodiscard]] Result<GpioLog> read_gpio_log(const std::string& path);
[[nodiscard]] Result<GpioLog> parse_gpio_log(std::string_view text, std::string_view name);

/// The lines of a log, each edge when the clock has come to its stamp. A line that the log has not told of cannot be
/// read yet.
class ReplayedGpio final : public GpioLines {
 public:
  /// All outlive this. `names`: of the inputs; an empty one is none.
  ReplayedGpio(const GpioLog& log, const Clock& clock, std::array<std::string, kMaxGpioInputs> names);
  [[nodiscard]] std::size_t input_count() const override { return inputs_; }
  [[nodiscard]] bool read_edge(GpioEdge& edge, TimeNs now_ns) override;
  [[nodiscard]] std::optional<bool> level(std::size_t input) override { return levels_[input]; }
  void set_output(bool) override {}
  [[nodiscard]] const GpioCounts& counts() const override { return counts_; }
  [[nodiscard]] bool is_over() const { return next_ == log_.records.size(); }

 private:
  const GpioLog& log_;
  const Clock& clock_;
  const std::array<std::string, kMaxGpioInputs> names_;
  std::size_t inputs_ = 0;
  std::size_t next_ = 0;
  std::array<std::optional<bool>, kMaxGpioInputs> levels_;
  GpioCounts counts_;
};

}  // namespace g3d::hal
