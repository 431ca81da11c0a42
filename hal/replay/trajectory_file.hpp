// SPDX-License-Identifier: Apache-2.0
// Trajectories in TUM's text format: `stamp_s tx ty tz qx qy qz qw` per line, T_world_camera, `#` begins a comment.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/image/atomic_file.hpp"
#include "hal/messages.hpp"
#include "hal/result.hpp"

namespace g3d::hal {

struct StampedPose {
  TimeNs stamp_ns = 0;
  Pose T_world_camera;  ///< as written: may hold NaN or a quaternion that is none, see is_valid
};

inline constexpr std::size_t kMaxTrajectory_bytes = std::size_t{1} << 30;

/// Every line must hold eight numbers, and no stamp may be earlier than the one before; errors name `name`:line.
Result<std::vector<StampedPose>> parse_trajectory(std::string_view text, std::string_view name);
Result<std::vector<StampedPose>> read_trajectory(const std::string& path);

/// One line as it is written, with a line feed. Digits suffice to read the same doubles back.
[[nodiscard]] std::string format_pose_line(const StampedPose& pose);
/// The same without allocating; the result lies in `buffer`.
using PoseLine = std::array<char, 256>;
[[nodiscard]] std::string_view format_pose_line(const StampedPose& pose, PoseLine& buffer);

/// Writes a trajectory while it is being made. See AtomicFile for what happens on failure.
class TrajectoryWriter {
 public:
  static Result<TrajectoryWriter> create(const std::string& path);
  /// Allocates nothing unless it fails.
  Result<void> append(const StampedPose& pose);
  Result<void> commit() { return file_.commit(); }

 private:
  explicit TrajectoryWriter(AtomicFile file) : file_(std::move(file)) {}
  AtomicFile file_;
};

Result<void> write_trajectory(const std::string& path, std::span<const StampedPose> poses);

}  // namespace g3d::hal
