// SPDX-License-Identifier: Apache-2.0
// Why bytes from a Kobuki's line were not believed. Every one is counted; `to_string` names it in the report.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace g3d::hal::kobuki {

enum class Reject : std::uint8_t {
  bad_length,        ///< a header that announces more or less than any frame has
  block_overruns,    ///< blocks do not tile the frame
  wrong_block_size,  ///< a known block of another size: line noise, or firmware from before 1.0
  bad_checksum,      ///< XOR over length, payload and checksum is not 0
  duplicate_block,   ///< the same block twice in one frame
  missing_block,     ///< a frame without what every frame has
  impossible_value,  ///< reserved flag bits, readings beyond their converter, an angle beyond +-180 degrees
  battery_voltage,   ///< not between 9 and 18 V
  time_step,         ///< stamp not 1..200 ms later than that of the packet before
  encoder_step,      ///< a wheel faster than it can turn
  gyro_angle_step,   ///< turned faster than the gyro can measure
  gyro_frame_step,   ///< count of raw gyro samples does not fit the time that passed
  count_,
};
inline constexpr std::size_t kRejectCount = static_cast<std::size_t>(Reject::count_);
[[nodiscard]] const char* to_string(Reject reason);

/// One writer; other threads get copies.
struct RejectCounts {
  std::array<std::uint64_t, kRejectCount> by_reason{};
  std::uint64_t skipped_bytes = 0;    ///< belong to no accepted frame
  std::uint64_t accepted_frames = 0;  ///< whole and with the right checksum; gates come later

  [[nodiscard]] std::uint64_t operator[](Reject reason) const { return by_reason[static_cast<std::size_t>(reason)]; }
  void count(Reject reason) { ++by_reason[static_cast<std::size_t>(reason)]; }
  [[nodiscard]] std::uint64_t total() const;
};

}  // namespace g3d::hal::kobuki
