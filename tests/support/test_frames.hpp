// SPDX-License-Identifier: Apache-2.0
// Small depth frames with poses to feed mappers with: noise of every kind, and recordings in fewer pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/geometry.hpp"
#include "hal/messages.hpp"
#include "tests/support/workload.hpp"

namespace g3d::test {

/// A Kinect's view in fewer pixels; 640 wide is the real one.
[[nodiscard]] hal::CameraModel small_camera(int width_px);

/// Smooth hills with noise, steps, holes of all sizes, readings too near and too far; coloured noise.
[[nodiscard]] hal::Frame random_frame(const hal::CameraModel& camera, std::uint64_t seed);
/// Anywhere within a few metres of the origin, turned anyhow.
[[nodiscard]] hal::Pose random_pose(std::uint64_t seed);
[[nodiscard]] std::vector<PosedImage> random_frames(const hal::CameraModel& camera, int count, std::uint64_t seed);

/// Every `every`-th frame of a workload, every `thin`-th pixel of it.
[[nodiscard]] Workload thinned(const Workload& full, std::size_t every, int thin);
/// The same of a real recording; without frames if it is not there.
[[nodiscard]] Workload thinned_recording(const std::string& name, std::size_t count, std::size_t every, int thin);

}  // namespace g3d::test
