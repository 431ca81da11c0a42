// SPDX-License-Identifier: Apache-2.0
// `g3dmap run --record FOLDER`: all that the run's map is made of, and what `replay` makes of such a folder.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/board.hpp"
#include "hal/depth_camera.hpp"
#include "hal/kobuki/line_recorder.hpp"
#include "hal/record/frame_recorder.hpp"
#include "hal/replay/recording.hpp"
#include "hal/result.hpp"
#include "main_commands.hpp"
#include "mapper/json_writer.hpp"

namespace g3d {

/// A camera whose frames are recorded as they come.
class RecordedCamera final : public hal::DepthCamera {
 public:
  RecordedCamera(hal::DepthCamera& camera, hal::FrameRecorder& recorder) : camera_(camera), recorder_(recorder) {}
  [[nodiscard]] const hal::CameraModel& model() const override { return camera_.model(); }
  [[nodiscard]] hal::CameraRead read(hal::Frame& out) override;
  [[nodiscard]] std::optional<std::size_t> frame_count() const override { return camera_.frame_count(); }
  [[nodiscard]] std::string last_error() const override { return camera_.last_error(); }

 private:
  hal::DepthCamera& camera_;
  hal::FrameRecorder& recorder_;
};

class RunRecording {
 public:
  /// Makes the folder. `board`: as the run has it, written beside. Without a camera only the base is recorded.
  [[nodiscard]] static hal::Result<std::unique_ptr<RunRecording>> begin(const std::string& folder,
                                                                        const board::Board& board,
                                                                        const hal::CameraModel& camera,
                                                                        bool with_colour);

  [[nodiscard]] hal::kobuki::LineRecorder* line() { return line_.get(); }
  /// The camera to read instead; `camera` outlives it.
  [[nodiscard]] hal::DepthCamera& camera(hal::DepthCamera& camera);
  /// nullptr without a camera.
  [[nodiscard]] hal::FrameRecorder* frames() { return frames_.get(); }

  /// All threads have ended: waits for the disk. Errors: the first that occurred.
  [[nodiscard]] hal::Result<void> finish();
  /// After finish(): `hash` of the run's map, and why it cannot be made again from the recording besides what is
  /// missing there.
  void end(const std::string& hash, std::vector<std::string> cannot);
  /// Writes the key "recording" and the object. After end().
  void write(mapper::JsonWriter& json, double run_s) const;

 private:
  RunRecording(std::string folder, std::unique_ptr<hal::kobuki::LineRecorder> line,
               std::unique_ptr<hal::FrameRecorder> frames)
      : folder_(std::move(folder)), line_(std::move(line)), frames_(std::move(frames)) {}

  std::string folder_;
  std::unique_ptr<hal::kobuki::LineRecorder> line_;
  std::unique_ptr<hal::FrameRecorder> frames_;
  std::unique_ptr<RecordedCamera> camera_;
  std::vector<std::string> cannot_;
};

/// The board that a recording brings along, if nobody names another one and it has one; else `named`.
[[nodiscard]] std::string board_of_recording(const std::string& folder, const std::string& named);

/// A recorded run, as replay takes it where its map is to be the run's own.
struct RecordedRun {
  hal::MappedLog log;
  std::unique_ptr<hal::ExactPoses> poses;
};
/// Nothing if the folder is another recording. Errors name the file.
[[nodiscard]] hal::Result<std::optional<RecordedRun>> open_recorded_run(const std::string& folder);
/// What replay says of its map: whether it is the run's own, and if not, why.
[[nodiscard]] std::string compare_with_run(const hal::MappedLog& log, const std::string& hash,
                                           std::uint64_t mapped_frames, std::size_t run_frames);

}  // namespace g3d
