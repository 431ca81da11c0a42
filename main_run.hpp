// SPDX-License-Identifier: Apache-2.0
// What every command does that maps frames from a camera whose poses are known or guessed.
#pragma once

#include <string>
#include <vector>

#include "board/board.hpp"
#include "hal/depth_camera.hpp"
#include "hal/replay/recording.hpp"
#include "main_commands.hpp"

namespace g3d {

struct Source {
  hal::DepthCamera& camera;
  const hal::PoseSource& poses;
  std::vector<std::string> notes;  ///< for the report
  /// Of a recorded run whose map is to be made again; then also what was taken as free before its first frame.
  const hal::MappedLog* run = nullptr;
  std::size_t run_frames = 0;
};

/// Maps until the camera ends or the user stops it, then writes what was made. Returns the process's exit code.
int map_source(Source source, const board::Board& board, const MappingOptions& options,
               const std::string& command_line);

}  // namespace g3d
