// SPDX-License-Identifier: Apache-2.0
#include "hal/kobuki/rejects.hpp"

#include <numeric>

namespace g3d::hal::kobuki {

const char* to_string(Reject reason) {
  switch (reason) {
    case Reject::bad_length:
      return "bad_length";
    case Reject::block_overruns:
      return "block_overruns";
    case Reject::wrong_block_size:
      return "wrong_block_size";
    case Reject::bad_checksum:
      return "bad_checksum";
    case Reject::duplicate_block:
      return "duplicate_block";
    case Reject::missing_block:
      return "missing_block";
    case Reject::impossible_value:
      return "impossible_value";
    case Reject::battery_voltage:
      return "battery_voltage";
    case Reject::time_step:
      return "time_step";
    case Reject::encoder_step:
      return "encoder_step";
    case Reject::gyro_angle_step:
      return "gyro_angle_step";
    case Reject::gyro_frame_step:
      return "gyro_frame_step";
    case Reject::count_:
      break;
  }
  return "unknown";
}

std::uint64_t RejectCounts::total() const {
  return std::accumulate(by_reason.begin(), by_reason.end(), std::uint64_t{0});
}

}  // namespace g3d::hal::kobuki
