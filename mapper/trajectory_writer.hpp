// SPDX-License-Identifier: Apache-2.0
// `trajectory.tum`: stamp and pose T_world_camera of every integrated frame, one line each, as the run goes on.
//   t_s tx ty tz qx qy qz qw
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "hal/image/atomic_file.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::mapper {

/// One thread. add() allocates nothing.
class TrajectoryWriter {
 public:
  static hal::Result<TrajectoryWriter> create(const std::string& path);

  void add(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera);
  /// Makes the file the real one; says what went wrong since the start.
  hal::Result<void> finish();

 private:
  explicit TrajectoryWriter(hal::AtomicFile file);

  hal::AtomicFile file_;
  hal::Result<void> first_failure_;
};

/// The line in `buffer`, with its new line.
using TrajectoryLine = std::array<char, 256>;
[[nodiscard]] std::string_view format_trajectory_line(hal::TimeNs stamp_ns, const hal::Pose& pose,
                                                      TrajectoryLine& buffer);

}  // namespace g3d::mapper
