// SPDX-License-Identifier: Apache-2.0
#include "main_save.hpp"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "hal/image/atomic_file.hpp"
#include "hal/image/file_bytes.hpp"

namespace g3d {
namespace {

/// Says on standard error that writing takes long; a call to a disk that does not answer cannot be broken off.
class SlowDiskNotice {
 public:
  explicit SlowDiskNotice(const std::string& folder) : thread_([this, folder] { wait_and_say(folder); }) {}
  ~SlowDiskNotice() {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  SlowDiskNotice(const SlowDiskNotice&) = delete;
  SlowDiskNotice& operator=(const SlowDiskNotice&) = delete;

 private:
  static constexpr std::chrono::seconds kLong{10};

  void wait_and_say(const std::string& folder) {
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kLong, [this] { return is_over_; })) return;
    fmt::print(stderr,
               "g3dmap: {}: still saving: the disk is slow or does not answer. The robot stands; Ctrl-C twice ends the "
               "program without the files\n",
               folder);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_over_ = false;  // under mutex_
  std::thread thread_;
};

nav::Patience patience(const RunFiles& files, hal::Clock& clock) {
  nav::Patience patience;
  patience.seconds = files.patience_s;
  patience.clock = &clock;
  patience.is_given_up = files.is_given_up;
  patience.on_wait = [&files](const hal::Error& first) {
    fmt::print(stderr, "g3dmap: {}; trying again for {:.0f} s, Ctrl-C gives it up\n", first.text, files.patience_s);
  };
  return patience;
}

hal::Result<mapper::WrittenFile> write_way(std::span<const hal::StampedPose> way, const std::string& path) {
  if (const auto written = hal::write_trajectory(path, way); !written) return written.error();
  std::error_code ignored;
  const auto bytes = std::filesystem::file_size(path, ignored);
  return mapper::WrittenFile{path, "camera poses", ignored ? 0 : bytes};
}

}  // namespace

hal::Result<void> open_folder(const std::string& folder) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) {
    return hal::Error{hal::Reason::io_error,
                      fmt::format("{}: cannot create this folder: {}; choose another --out", folder, code.message())};
  }
  const auto probe = hal::AtomicFile::create(folder + "/report.json");
  if (!probe) return probe.error();
  return {};
}

nav::Outputs save_run(const RunFiles& files) {
  const SlowDiskNotice notice(files.folder);
  hal::RealClock clock;
  std::vector<nav::OutputJob> jobs = nav::output_jobs(*files.map, files.options, files.folder);
  if (files.draw) {
    const std::string way_path = files.folder + "/trajectory.tum";
    jobs.push_back({way_path, [&files, way_path] { return write_way(files.way, way_path); }});
    const std::string picture_path = files.folder + "/exploration.png";
    jobs.push_back({picture_path, [&files, picture_path] { return files.draw(picture_path); }});
  }
  nav::Outputs outputs = nav::write_patiently(jobs, patience(files, clock));
  if (files.finish_recording) {
    if (const auto recorded = files.finish_recording(); !recorded) outputs.failures.push_back(recorded.error());
  }
  return outputs;
}

std::string late_files_note(int late_files) {
  return fmt::format("{} files were not taken by the disk at first, and are there now", late_files);
}

std::vector<hal::StampedPose> corrected(std::vector<hal::StampedPose> way, const mapper::submaps::DrivingLoops* loops) {
  if (loops == nullptr) return way;
  for (hal::StampedPose& pose : way) pose.T_world_camera = loops->corrected(pose.stamp_ns, pose.T_world_camera);
  return way;
}

std::vector<hal::Pose> poses_of(std::span<const hal::StampedPose> way) {
  std::vector<hal::Pose> poses;
  poses.reserve(way.size());
  for (const hal::StampedPose& stamped : way) poses.push_back(stamped.T_world_camera);
  return poses;
}

void save_report(const RunFiles& files, const std::string& json, nav::Outputs& outputs) {
  const SlowDiskNotice notice(files.folder);
  hal::RealClock clock;
  const std::string path = files.folder + "/report.json";
  const auto write = [&]() -> hal::Result<mapper::WrittenFile> {
    if (const auto written = hal::write_file_atomic(path, json); !written) return written.error();
    return mapper::WrittenFile{path, "what happened", json.size()};
  };
  // Where the files before could not be written in time, it would wait in vain as well.
  nav::Outputs report = outputs.failures.empty() ? nav::write_patiently({{path, write}}, patience(files, clock))
                                                 : nav::write_patiently({{path, write}});
  outputs.files.insert(outputs.files.end(), report.files.begin(), report.files.end());
  outputs.failures.insert(outputs.failures.end(), report.failures.begin(), report.failures.end());
}

}  // namespace g3d
