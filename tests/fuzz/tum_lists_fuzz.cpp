// SPDX-License-Identifier: Apache-2.0
// Every text file of a recording, and what is looked up in it; a trajectory that was read is written and read again.
#include <cstdlib>

#include "hal/replay/recorded_poses.hpp"
#include "hal/replay/tum_lists.hpp"

namespace {

using namespace g3d::hal;

void fuzz_lists(std::string_view text) {
  (void)parse_camera(text, "camera.txt").ok();
  Result<std::vector<ImageEntry>> list = parse_image_list(text, "rgb.txt");
  if (!list) return;
  for (const ImageEntry& entry : list.value()) {
    if (entry.file.empty() || entry.file.front() == '/') std::abort();
  }
  std::vector<ImageEntry> sorted;
  for (const ImageEntry& entry : list.value()) {
    if (sorted.empty() || entry.stamp_ns >= sorted.back().stamp_ns) sorted.push_back(entry);
  }
  for (const ImageEntry& entry : list.value()) (void)nearest_entry(sorted, entry.stamp_ns + 1, 20'000'000);
}

void fuzz_trajectory(std::string_view text) {
  const Result<std::vector<StampedPose>> poses = parse_trajectory(text, "groundtruth.txt");
  if (!poses) return;
  std::string written;
  for (const StampedPose& pose : poses.value()) written += format_pose_line(pose);
  const Result<std::vector<StampedPose>> again = parse_trajectory(written, "again");
  if (!again || again.value().size() != poses.value().size()) std::abort();
  const RecordedPoses source(poses.value());
  for (std::size_t i = 0; i < again.value().size(); ++i) {
    if (again.value()[i].stamp_ns != poses.value()[i].stamp_ns) std::abort();
    Pose pose;
    const TimeNs stamp_ns = poses.value()[i].stamp_ns + 1000;
    if (source.pose_at(stamp_ns, pose) == PoseStatus::ok && !is_valid(pose)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  const std::string_view text(reinterpret_cast<const char*>(data), size_bytes);
  fuzz_lists(text);
  fuzz_trajectory(text);
  return 0;
}
