// SPDX-License-Identifier: Apache-2.0
#include "main_record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "board/board_file.hpp"
#include "hal/image/file_bytes.hpp"

namespace g3d {

hal::CameraRead RecordedCamera::read(hal::Frame& out) {
  const hal::CameraRead read = camera_.read(out);
  if (read.event == hal::CameraEvent::frame) recorder_.put_frame(out);
  return read;
}

hal::Result<std::unique_ptr<RunRecording>> RunRecording::begin(const std::string& folder, const board::Board& board,
                                                               const hal::CameraModel& camera, bool with_colour) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) {
    return hal::Error{hal::Reason::io_error, fmt::format("{}: cannot create this folder: {}; choose another --record",
                                                         folder, code.message())};
  }
  if (std::filesystem::exists(folder + "/depth.txt", code)) {
    return hal::Error{hal::Reason::no_permission,
                      fmt::format("{}: there is a recording already; choose another --record, or remove it", folder)};
  }
  auto line = hal::kobuki::LineRecorder::create(folder + "/kobuki.bin");
  if (!line) return line.error();
  if (const auto written = hal::write_file_atomic(folder + "/board.toml", board::to_text(board)); !written) {
    return written.error();
  }
  std::unique_ptr<hal::FrameRecorder> frames;
  if (board.camera_source != "none") {
    auto created = hal::FrameRecorder::create(folder, camera, with_colour);
    if (!created) return created.error();
    frames = std::move(created).value();
  }
  return std::unique_ptr<RunRecording>(new RunRecording(folder, std::move(line).value(), std::move(frames)));
}

hal::DepthCamera& RunRecording::camera(hal::DepthCamera& camera) {
  if (frames_ == nullptr) return camera;
  if (camera_ == nullptr) camera_ = std::make_unique<RecordedCamera>(camera, *frames_);
  return *camera_;
}

hal::Result<void> RunRecording::finish() {
  const hal::Result<void> frames = frames_ != nullptr ? frames_->finish() : hal::Result<void>{};
  const hal::Result<void> line = line_->finish();
  if (frames.ok() || line.ok()) return frames.ok() ? line : frames;
  return hal::Error{frames.error().reason, frames.error().text + "\n  " + line.error().text};
}

void RunRecording::end(const std::string& hash, std::vector<std::string> cannot) {
  cannot_ = std::move(cannot);
  if (frames_ == nullptr) return;
  const hal::RecordCounts counts = frames_->counts();
  const auto missing = [&](std::uint64_t count, const char* what) {
    if (count > 0) cannot_.push_back(fmt::format("{} {}", count, what));
  };
  missing(counts.lost_behind, "frames are missing: the recorder was behind");
  missing(counts.lost_disk, "frames are missing: the disk refused them");
  missing(counts.lost_colours, "frames are recorded without their colour: the disk refused it");
  missing(counts.lost_poses, "poses of mapped frames are missing");
  for (const std::string& why : cannot_) (void)frames_->note("cannot " + why);
  (void)frames_->note("map " + hash);
}

void RunRecording::write(mapper::JsonWriter& json, double run_s) const {
  json.key("recording").begin_object().member("folder", folder_);
  json.member("lost_base_bytes", line_->lost_bytes());
  if (frames_ != nullptr) {
    const hal::RecordCounts counts = frames_->counts();
    json.key("frames").begin_object().member("delivered", counts.delivered).member("written", counts.written);
    json.key("lost").begin_object().member("behind", counts.lost_behind).member("disk", counts.lost_disk);
    json.end_object().end_object().member("lost_colours", counts.lost_colours);
    json.member("poses", counts.poses).member("lost_poses", counts.lost_poses).member("masked", counts.masked);
    json.member("bytes", counts.bytes);
    json.member("bytes_per_s", run_s > 0.0 ? std::round(static_cast<double>(counts.bytes) / run_s) : 0.0);
    json.member("writer_cpu_s", std::round(static_cast<double>(counts.writer_cpu_ns) * 1e-6) * 1e-3);
    json.member("repeatable", cannot_.empty()).key("why_not").begin_array();
    for (const std::string& why : cannot_) json.value(why);
    json.end_array();
  }
  json.end_object();
}

std::string board_of_recording(const std::string& folder, const std::string& named) {
  std::error_code ignored;
  const std::string own = folder + "/board.toml";
  return named.empty() && std::filesystem::exists(own, ignored) ? own : named;
}

hal::Result<std::optional<RecordedRun>> open_recorded_run(const std::string& folder) {
  std::error_code ignored;
  const std::string path = folder + "/mapped.txt";
  if (!std::filesystem::exists(path, ignored)) return std::optional<RecordedRun>{};
  const auto text = hal::read_text_file(path, hal::kMaxMappedLog_bytes);
  if (!text) return text.error();
  auto log = hal::parse_mapped_log(text.value(), path);
  if (!log) return log.error();
  auto poses = hal::read_trajectory(folder + "/trajectory.tum");
  if (!poses) return poses.error();
  RecordedRun run;
  run.log = std::move(log).value();
  run.poses = std::make_unique<hal::ExactPoses>(std::move(poses).value());
  return std::optional<RecordedRun>(std::move(run));
}

std::string compare_with_run(const hal::MappedLog& log, const std::string& hash, std::uint64_t mapped_frames,
                             std::size_t run_frames) {
  if (!log.hash.empty() && log.hash == hash) return "the map is that of the recorded run, to the last bit";
  std::string why;
  for (const std::string& reason : log.cannot) why += (why.empty() ? "" : "; ") + reason;
  if (mapped_frames != run_frames) {
    why += fmt::format("{}{} frames were mapped here and {} in the run", why.empty() ? "" : "; ", mapped_frames,
                       run_frames);
  }
  if (log.hash.empty()) {
    return fmt::format("the recorded run did not come to its end, so nobody knows the hash of its map{}{}",
                       why.empty() ? "" : ": ", why);
  }
  return fmt::format("the map is not that of the recorded run ({}): {}", log.hash,
                     why.empty() ? "other options, or another version of the program" : why);
}

}  // namespace g3d
