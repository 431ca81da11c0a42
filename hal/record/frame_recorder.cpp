// SPDX-License-Identifier: Apache-2.0
#include "hal/record/frame_recorder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <utility>

#include "hal/disk.hpp"
#include "hal/image/atomic_file.hpp"
#include "hal/image/file_bytes.hpp"
#include "hal/linux/cpu_time.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/replay/trajectory_file.hpp"

namespace g3d::hal {
namespace {

// A disk that does not answer for a second or two costs nothing: at 640x480 these are 50 frames.
constexpr std::size_t kWaiting_bytes = std::size_t{75} << 20;
constexpr std::size_t kLeastWaiting = 4;
constexpr std::size_t kMostWaiting = 64;
constexpr std::size_t kMappedWaiting = 1024;
constexpr std::size_t kMasksWaiting = 8;

std::size_t frames_waiting(const CameraModel& camera) {
  return std::clamp(kWaiting_bytes / (5 * camera.pixel_count()), kLeastWaiting, kMostWaiting);
}

Result<void> make_subfolder(const std::string& path) {
  if (::mkdir(path.c_str(), 0755) == 0 || errno == EEXIST) return {};
  return system_error(path, "cannot be made", errno);
}

std::string camera_line(const CameraModel& camera) {
  // As doubles, whose digits read back the same floats.
  const auto exact = [](float x) { return static_cast<double>(x); };
  return fmt::format("# fx fy cx cy depth_units_per_metre width height\n{} {} {} {} {} {} {}\n", exact(camera.fx_px),
                     exact(camera.fy_px), exact(camera.cx_px), exact(camera.cy_px), exact(camera.depth_units_per_metre),
                     camera.width_px, camera.height_px);
}

ImageSize image_size_of(const CameraModel& camera) { return {camera.width_px, camera.height_px}; }

void copy_depth(const Frame& from, const CameraModel& camera, Frame& to) {
  to.stamp_ns = from.stamp_ns;
  to.sequence = from.sequence;
  to.has_colour = false;
  std::copy_n(from.depth.get(), camera.pixel_count(), to.depth.get());
}

}  // namespace

Result<std::unique_ptr<FrameRecorder>> FrameRecorder::create(const std::string& folder, const CameraModel& camera,
                                                             bool with_colour) {
  for (const char* const name : {"/depth", "/rgb", "/masked"}) {
    if (auto made = make_subfolder(folder + name); !made) return made.error();
  }
  if (auto written = write_file_atomic(folder + "/camera.txt", camera_line(camera)); !written) return written.error();
  auto depth_list = AppendFile::create(folder + "/depth.txt");
  if (!depth_list) return depth_list.error();
  auto rgb_list = AppendFile::create(folder + "/rgb.txt");
  if (!rgb_list) return rgb_list.error();
  auto trajectory = AppendFile::create(folder + "/trajectory.tum");
  if (!trajectory) return trajectory.error();
  auto mapped = AppendFile::create(folder + "/mapped.txt");
  if (!mapped) return mapped.error();
  if (!with_colour) {
    if (const int error = mapped.value().append("colour no\n"); error != 0) {
      return system_error(mapped.value().path(), "cannot be written", error);
    }
  }
  std::unique_ptr<FrameRecorder> recorder(
      new FrameRecorder(folder, camera, with_colour,
                        {std::move(depth_list).value(), std::move(rgb_list).value(), std::move(trajectory).value(),
                         std::move(mapped).value()}));
  return recorder;
}

FrameRecorder::FrameRecorder(std::string folder, const CameraModel& camera, bool with_colour, Files files)
    : folder_(std::move(folder)),
      camera_(camera),
      with_colour_(with_colour),
      files_(std::move(files)),
      packer_(image_size_of(camera)),
      frames_(camera, frames_waiting(camera)),
      to_write_(frames_waiting(camera)),
      masks_(camera, kMasksWaiting),
      mapped_(kMappedWaiting),
      writer_([this] { write_all(); }) {}

FrameRecorder::~FrameRecorder() { (void)finish(); }

void FrameRecorder::put_frame(const Frame& frame) {
  count(delivered_);
  std::uint32_t index = 0;
  if (!frames_.try_acquire(index)) {
    count(behind_);
    return;
  }
  Frame& copy = frames_[index];
  copy_depth(frame, camera_, copy);
  copy.has_colour = frame.has_colour && with_colour_;
  if (copy.has_colour) std::copy_n(frame.rgb.get(), 3 * camera_.pixel_count(), copy.rgb.get());
  (void)to_write_.try_push(index);  // has room for every frame of the pool
  writer_waits_.wake();
}

void FrameRecorder::put_mapped(const MappedNote& note, const Frame* masked) {
  Mapped mapped{note, -1};
  if (masked != nullptr) {
    std::uint32_t index = 0;
    if (!masks_.try_acquire(index)) {
      count(lost_poses_);
      return;
    }
    copy_depth(*masked, camera_, masks_[index]);
    mapped.masked_index = static_cast<std::int32_t>(index);
  }
  if (mapped_.try_push(mapped)) {
    writer_waits_.wake();
    return;
  }
  // The mask stays taken: only the writer may give it back. By then the disk has stood still for a minute.
  count(lost_poses_);
}

void FrameRecorder::write_all() {
  (void)pthread_setname_np(pthread_self(), "recorder");
  std::uint32_t index = 0;
  Mapped mapped;
  bool is_mapped = false;
  while (writer_waits_.wait([&] {
    if (mapped_.try_pop(mapped)) {
      is_mapped = true;
      return true;
    }
    is_mapped = false;
    return to_write_.try_pop(index);
  })) {
    if (!is_mapped) {
      write_frame(frames_[index]);
      frames_.release(index);
    } else {
      write_mapped(mapped);
      if (mapped.masked_index >= 0) masks_.release(static_cast<std::uint32_t>(mapped.masked_index));
    }
    cpu_ns_.store(thread_cpu_ns(), std::memory_order_relaxed);
  }
}

bool FrameRecorder::append(AppendFile& file, std::string_view line) {
  const int error = file.append(line);
  if (error == 0) {
    bytes_.fetch_add(line.size(), std::memory_order_relaxed);
    return true;
  }
  if (!first_error_) first_error_ = system_error(file.path(), "the recording has a gap", error);
  return false;
}

/// `kind`: the subfolder. The path is left in path_.
bool FrameRecorder::write_file(const char* kind, TimeNs stamp_ns, std::span<const std::uint8_t> bytes) {
  std::array<char, kMaxStampChars> stamp;
  const char* const end = format_stamp_to(stamp.data(), stamp_ns);
  path_.clear();
  fmt::format_to(std::back_inserter(path_), "{}/{}/{}.g3i", folder_, kind,
                 std::string_view(stamp.data(), static_cast<std::size_t>(end - stamp.data())));
  const int fd = disk().open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  int error = fd < 0 ? errno : 0;
  for (std::size_t done = 0; error == 0 && done < bytes.size();) {
    const ssize_t count = disk().write(fd, bytes.data() + done, bytes.size() - done);
    if (count > 0) done += static_cast<std::size_t>(count);
    if (count == 0) error = EIO;
    if (count < 0 && errno != EINTR) error = errno;
  }
  if (fd >= 0) ::close(fd);
  if (error == 0) {
    bytes_.fetch_add(bytes.size(), std::memory_order_relaxed);
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "{} {}\n",
                   std::string_view(stamp.data(), static_cast<std::size_t>(end - stamp.data())),
                   std::string_view(path_).substr(folder_.size() + 1));
    return true;
  }
  if (!first_error_) first_error_ = system_error(path_, "the recording has a gap", error);
  if (fd >= 0) (void)::unlink(path_.c_str());
  return false;
}

void FrameRecorder::write_frame(const Frame& frame) {
  // Colour first: a frame that is listed without it would look as if it had none.
  const std::size_t pixels = camera_.pixel_count();
  bool has_all_colour = true;
  if (frame.has_colour) {
    const auto rgb = packer_.pack_rgb(image_size_of(camera_), {frame.rgb.get(), 3 * pixels});
    has_all_colour = !rgb.empty() && write_file("rgb", frame.stamp_ns, rgb) && append(files_.rgb_list, line_);
  }
  const auto depth = packer_.pack_depth(image_size_of(camera_), {frame.depth.get(), pixels});
  const bool is_written =
      !depth.empty() && write_file("depth", frame.stamp_ns, depth) && append(files_.depth_list, line_);
  count(is_written ? written_ : disk_);
  if (is_written && !has_all_colour) count(colours_);
}

void FrameRecorder::write_mapped(const Mapped& mapped) {
  const MappedNote& note = mapped.note;
  bool is_written = true;
  if (note.footprint) {
    const auto& f = *note.footprint;
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "footprint {} {} {} {} {}\n", f[0], f[1], f[2], f[3], f[4]);
    is_written = append(files_.mapped, line_);
  }
  if (mapped.masked_index >= 0) {
    const Frame& masked = masks_[static_cast<std::uint32_t>(mapped.masked_index)];
    const auto depth = packer_.pack_depth(image_size_of(camera_), {masked.depth.get(), camera_.pixel_count()});
    is_written = is_written && !depth.empty() && write_file("masked", note.stamp_ns, depth);
    if (is_written) {
      line_.insert(0, "masked ");
      is_written = append(files_.mapped, line_);
    }
    count(masked_);
  }
  PoseLine buffer;
  is_written = is_written && append(files_.trajectory, format_pose_line({note.stamp_ns, note.T_world_camera}, buffer));
  count(is_written ? poses_ : lost_poses_);
}

Result<void> FrameRecorder::finish() {
  if (writer_.joinable()) {
    writer_waits_.stop();
    writer_.join();
  }
  if (first_error_) return *first_error_;
  return {};
}

Result<void> FrameRecorder::note(const std::string& line) {
  if (const int error = files_.mapped.append(line + "\n"); error != 0) {
    return system_error(files_.mapped.path(), "the recording has no end", error);
  }
  return {};
}

RecordCounts FrameRecorder::counts() const {
  const auto read = [](const std::atomic<std::uint64_t>& counter) { return counter.load(std::memory_order_relaxed); };
  RecordCounts counts;
  counts.delivered = read(delivered_);
  counts.written = read(written_);
  counts.lost_behind = read(behind_);
  counts.lost_disk = read(disk_);
  counts.lost_colours = read(colours_);
  counts.poses = read(poses_);
  counts.lost_poses = read(lost_poses_);
  counts.masked = read(masked_);
  counts.bytes = read(bytes_);
  counts.writer_cpu_ns = cpu_ns_.load(std::memory_order_relaxed);
  return counts;
}

}  // namespace g3d::hal
