// SPDX-License-Identifier: Apache-2.0
#include "tests/support/looped_drive.hpp"

#include <algorithm>

namespace g3d::test {
namespace {

constexpr double kStep_s = 0.2;

}  // namespace

mapper::MapperConfig looped_drive_config() {
  mapper::MapperConfig config;
  config.with_colour = false;
  config.capacity = {1U << 15, 1U << 14, 1U << 15};
  return config;
}

hal::Pose DriveTwice::true_pose_at(hal::TimeNs stamp_ns) const {
  const auto found = std::find_if(work.frames.begin(), work.frames.end(),
                                  [&](const PosedImage& image) { return image.frame.stamp_ns == stamp_ns; });
  return found->T_world_camera;
}

std::vector<hal::StampedPose> DriveTwice::truth() const {
  std::vector<hal::StampedPose> poses;
  for (const PosedImage& image : work.frames) poses.push_back({image.frame.stamp_ns, image.T_world_camera});
  return poses;
}

DriveTwice twice_through(const std::string& builtin, int frames) {
  DriveTwice twice{simulated_drive(builtin, frames, kStep_s, 0.0, 160)};
  Workload again = simulated_drive(builtin, frames, kStep_s, 0.0, 160);
  const hal::TimeNs later_ns = twice.work.frames.back().frame.stamp_ns + static_cast<hal::TimeNs>(1e9 * kStep_s) -
                               twice.work.frames.front().frame.stamp_ns;
  for (PosedImage& image : again.frames) {
    image.frame.stamp_ns += later_ns;
    twice.work.frames.push_back(std::move(image));
  }
  return twice;
}

UnalignedDrive::UnalignedDrive(const DriveTwice& twice, const hal::PoseDrift& drift)
    : twice_(twice),
      odometry_(hal::drifted(twice.truth(), drift)),
      mapper_(looped_drive_config(), twice.work.camera),
      samples_(twice.work.camera),
      sketch_(twice.work.camera),
      chain_(mapper_.map()) {}

bool UnalignedDrive::next_submap() {
  while (next_ < twice_.work.frames.size()) {
    const hal::Frame& frame = twice_.work.frames[next_].frame;
    const hal::Pose& pose = odometry_[next_++].T_world_camera;
    (void)mapper_.integrate(frame, pose);
    samples_.compute(frame.depth.get());
    sketch_.add(frame, pose);
    if (!chain_.add_frame(frame.stamp_ns, pose, mapper_.changed_slots(), samples_.all())) continue;
    return chain_.finish_submap(sketch_.take());
  }
  return false;
}

}  // namespace g3d::test
