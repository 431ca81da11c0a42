// SPDX-License-Identifier: Apache-2.0
// What a run writes while it goes on: the trajectory of the integrated frames, if asked also as odometry had it, and
// the progress line.
#pragma once

#include "hal/clock.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "hal/result.hpp"
#include "mapper/pipeline.hpp"
#include "mapper/progress_bar.hpp"

namespace g3d::mapper {

class RunSink final : public FrameSink {
 public:
  /// What is referred to outlives the sink. `odometry` may be nullptr.
  RunSink(hal::TrajectoryWriter& trajectory, ProgressBar& progress, const hal::Clock& clock,
          hal::TrajectoryWriter* odometry = nullptr);

  /// Writer thread. A line that cannot be written is told by finish(): the map goes on.
  void on_frame(const MappedFrame& frame) override;
  void on_progress(const Progress& progress) override;

  /// After the run: ends the progress line and makes the trajectory files the real ones.
  hal::Result<void> finish();

 private:
  hal::TrajectoryWriter& trajectory_;
  hal::TrajectoryWriter* odometry_;
  ProgressBar& bar_;
  const hal::Clock& clock_;
  Progress last_progress_;
  hal::Result<void> first_failure_;
};

}  // namespace g3d::mapper
