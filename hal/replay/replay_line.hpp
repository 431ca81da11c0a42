// SPDX-License-Identifier: Apache-2.0
// A recorded base at the end of a line: what it said comes when the clock says that it came. What is written to it goes
// nowhere, as a recording does not react.
#pragma once

#include "hal/byte_line.hpp"
#include "hal/clock.hpp"
#include "hal/replay/kobuki_log.hpp"

namespace g3d::hal {

/// One thread. Log and clock must outlive it.
class ReplayLine final : public ByteLine {
 public:
  ReplayLine(const KobukiLog& log, const Clock& clock) : clock_(clock), cursor_(log.records()) {}
  [[nodiscard]] std::size_t read(std::span<std::uint8_t> into) override;
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) override;
  /// Lost once all of the recording has been read.
  [[nodiscard]] LineState state() const override;
  /// When the next bytes come; nothing at the end.
  [[nodiscard]] std::optional<TimeNs> next_ns() const;
  [[nodiscard]] std::uint64_t swallowed_bytes() const { return swallowed_bytes_; }

 private:
  const Clock& clock_;
  KobukiLog::Cursor cursor_;
  std::size_t taken_bytes_ = 0;  // of the record at the cursor
  std::uint64_t swallowed_bytes_ = 0;
};

}  // namespace g3d::hal
