// SPDX-License-Identifier: Apache-2.0
#include "mapper/run_sink.hpp"

#include <utility>

namespace g3d::mapper {

RunSink::RunSink(hal::TrajectoryWriter& trajectory, ProgressBar& progress, const hal::Clock& clock,
                 hal::TrajectoryWriter* odometry)
    : trajectory_(trajectory), odometry_(odometry), bar_(progress), clock_(clock) {}

void RunSink::on_frame(const MappedFrame& frame) {
  if (!first_failure_) return;
  hal::Result<void> written = trajectory_.append({frame.stamp_ns, frame.T_world_camera});
  if (written && odometry_ != nullptr) written = odometry_->append({frame.stamp_ns, frame.T_odometry_camera});
  if (!written) first_failure_ = std::move(written);
}

void RunSink::on_progress(const Progress& progress) {
  last_progress_ = progress;
  bar_.update(progress, clock_.now());
}

hal::Result<void> RunSink::finish() {
  bar_.finish(last_progress_, clock_.now());
  if (!first_failure_) return first_failure_;
  hal::Result<void> committed = trajectory_.commit();
  if (committed && odometry_ != nullptr) committed = odometry_->commit();
  return committed;
}

}  // namespace g3d::mapper
