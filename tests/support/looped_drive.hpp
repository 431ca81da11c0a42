// SPDX-License-Identifier: Apache-2.0
// A simulated camera that goes the same way twice, and a map of it by odometry alone, submap by submap.
#pragma once

#include <string>
#include <vector>

#include "hal/sim/pose_drift.hpp"
#include "mapper/mapper.hpp"
#include "mapper/submaps/space_sketch.hpp"
#include "mapper/submaps/submap_chain.hpp"
#include "tests/support/workload.hpp"

namespace g3d::test {

struct DriveTwice {
  Workload work;
  [[nodiscard]] hal::Pose true_pose_at(hal::TimeNs stamp_ns) const;
  [[nodiscard]] std::vector<hal::StampedPose> truth() const;
};

/// Some frames of a built-in drive, 160x120 at 5 Hz; then the camera is back at the start, in one step if the way does
/// not end there, and goes the same way again.
[[nodiscard]] DriveTwice twice_through(const std::string& builtin, int frames);
/// 25 s of the furnished room.
[[nodiscard]] inline DriveTwice twice_through_a_room() { return twice_through("furnished_room", 125); }

/// For one such drive, without colours.
[[nodiscard]] mapper::MapperConfig looped_drive_config();

class UnalignedDrive {
 public:
  UnalignedDrive(const DriveTwice& twice, const hal::PoseDrift& drift);
  /// Maps on until a submap is finished. False: the way is at its end.
  [[nodiscard]] bool next_submap();
  [[nodiscard]] const mapper::submaps::SubmapChain& chain() const { return chain_; }
  [[nodiscard]] mapper::submaps::SubmapChain& chain() { return chain_; }

 private:
  const DriveTwice& twice_;
  std::vector<hal::StampedPose> odometry_;
  mapper::Mapper mapper_;
  mapper::align::DepthSamples samples_;
  mapper::submaps::SpaceSketch sketch_;
  mapper::submaps::SubmapChain chain_;
  std::size_t next_ = 0;
};

}  // namespace g3d::test
