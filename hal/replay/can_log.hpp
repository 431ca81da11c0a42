// SPDX-License-Identifier: Apache-2.0
// `can.log`, in candump's own format (see can/candump.hpp), and a port that says it again. A process that was killed
// may leave half a line at the end, which is no error.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/can/candump.hpp"
#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

/// A day of a busy e-stop node, or minutes of a full bus.
inline constexpr std::size_t kMaxCanLog_bytes = std::size_t{1} << 28;

struct CanLog {
  std::vector<can::StampedCanFrame> frames;  ///< in the order of the file, which is that of time
  std::string interface;                     ///< of the first line
  std::size_t torn_bytes = 0;                ///< of half a line at the end, dropped
};

/// Checks the whole file. Errors: what read_file says; malformed, with file, line and reason.
[[nodiscard]] Result<CanLog> read_can_log(const std::string& path);
[[nodiscard]] Result<CanLog> parse_can_log(std::string_view text, std::string_view name);

/// Gives each frame when the clock has come to its stamp; what is written to it goes nowhere and is counted.
class ReplayedCan final : public can::CanPort {
 public:
  /// Both outlive this.
  ReplayedCan(const CanLog& log, const Clock& clock) : log_(log), clock_(clock) {}
  [[nodiscard]] bool read(can::CanFrame& frame) override;
  bool write(const can::CanFrame&) override {
    ++counts_.sent;
    return true;
  }
  [[nodiscard]] const can::CanCounts& counts() const override { return counts_; }
  [[nodiscard]] bool is_over() const { return next_ == log_.frames.size(); }

 private:
  const CanLog& log_;
  const Clock& clock_;
  std::size_t next_ = 0;
  can::CanCounts counts_;
};

}  // namespace g3d::hal
