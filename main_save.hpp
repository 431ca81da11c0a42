// SPDX-License-Identifier: Apache-2.0
// What a robot's run leaves in its folder. A run that took hours is not thrown away because a disk is full at its end:
// what failed is tried again for some time, and a person is told what is being waited for.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/replay/trajectory_file.hpp"
#include "main_commands.hpp"
#include "mapper/report.hpp"
#include "mapper/submaps/driving_loops.hpp"
#include "nav/outputs.hpp"

namespace g3d {

struct RunFiles {
  std::string folder;
  double patience_s = 0.0;
  std::span<const hal::StampedPose> way;  ///< of the integrated frames
  const mapper::VoxelMap* map = nullptr;
  nav::OutputOptions options;
  /// exploration.png. Empty: nobody has driven, and there is no way to be written either
  std::function<hal::Result<mapper::WrittenFile>(const std::string& path)> draw;
  std::function<hal::Result<void>()> finish_recording;  ///< of what was written all along. May be empty
  std::function<bool()> is_given_up;                    ///< Ctrl-C meanwhile
};

/// Creates the folder and sees whether it takes files. Errors: those of the file system, with what to do.
[[nodiscard]] hal::Result<void> open_folder(const std::string& folder);
/// All but report.json: the way, the map in all formats, the pictures. A disk that does not answer is told on standard
/// error.
[[nodiscard]] nav::Outputs save_run(const RunFiles& files);
/// For report.json.
[[nodiscard]] std::string late_files_note(int late_files);
/// Where the frames were as far as is known at the end; as they were mapped, without loops (nullptr).
[[nodiscard]] std::vector<hal::StampedPose> corrected(std::vector<hal::StampedPose> way,
                                                      const mapper::submaps::DrivingLoops* loops);
[[nodiscard]] std::vector<hal::Pose> poses_of(std::span<const hal::StampedPose> way);
/// report.json; it takes its place among the outputs, or in their failures.
void save_report(const RunFiles& files, const std::string& json, nav::Outputs& outputs);

}  // namespace g3d
