// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/replay_camera.hpp"

#include <fmt/format.h>

#include <span>
#include <utility>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

bool begins_like_jpeg(std::span<const std::uint8_t> file) {
  return file.size() >= 2 && file[0] == 0xFF && file[1] == 0xD8;
}

ImageSize size_of(const CameraModel& model) { return {model.width_px, model.height_px}; }

}  // namespace

Result<std::unique_ptr<ReplayCamera>> ReplayCamera::open(const std::string& folder) {
  Result<TumFolder> log = TumFolder::open(folder);
  if (!log) return log.error();
  return std::make_unique<ReplayCamera>(std::move(log).value());
}

ReplayCamera::ReplayCamera(TumFolder log) : log_(std::move(log)) {
  // A PNG is hardly ever larger than its pixels, so this is the last allocation for file contents.
  file_.reserve(3 * log_.camera.pixel_count() + 64 * 1024);
}

CameraRead ReplayCamera::read(Frame& out) {
  if (next_ == log_.frames.size()) return {CameraEvent::end, {}};
  const RecordedFrame& recorded = log_.frames[next_];
  out.sequence = next_++;
  out.stamp_ns = recorded.stamp_ns;
  out.has_colour = false;

  if (newest_ns_ && recorded.stamp_ns <= *newest_ns_) {
    last_error_ = fmt::format("{}: stamp {} is not later than {} before it; sort depth.txt by time",
                              recorded.depth_path, format_stamp(recorded.stamp_ns), format_stamp(*newest_ns_));
    return {CameraEvent::dropped, DropReason::time_backwards};
  }
  newest_ns_ = recorded.stamp_ns;

  if (const Result<void> depth = read_depth(recorded, out); !depth) {
    last_error_ = depth.error().text;
    const bool wrong_size = depth.error().reason == Reason::out_of_range;
    return {CameraEvent::dropped, wrong_size ? DropReason::wrong_size : DropReason::unreadable_depth};
  }
  out.has_colour = read_colour(recorded, out);
  return {CameraEvent::frame, {}};
}

Result<void> ReplayCamera::read_depth(const RecordedFrame& recorded, Frame& out) {
  if (Result<void> read = read_file_into(recorded.depth_path, kMaxImageFile_bytes, file_); !read) return read;
  if (is_packed_image(file_)) {
    return packed_.unpack_depth(file_, recorded.depth_path, size_of(log_.camera),
                                std::span(out.depth.get(), log_.camera.pixel_count()));
  }
  return png_.decode_depth(file_, recorded.depth_path, size_of(log_.camera),
                           std::span(out.depth.get(), log_.camera.pixel_count()));
}

bool ReplayCamera::read_colour(const RecordedFrame& recorded, Frame& out) {
  if (recorded.colour_path.empty()) {
    ++unmatched_colours_;
    return false;
  }
  if (const Result<void> colour = decode_colour(recorded.colour_path, out); !colour) {
    ++broken_colours_;
    last_error_ = colour.error().text;
    return false;
  }
  return true;
}

Result<void> ReplayCamera::decode_colour(const std::string& path, Frame& out) {
  if (Result<void> read = read_file_into(path, kMaxImageFile_bytes, file_); !read) return read;
  const std::span<std::uint8_t> rgb(out.rgb.get(), 3 * log_.camera.pixel_count());
  if (begins_like_jpeg(file_)) return jpeg_.decode_rgb(file_, path, size_of(log_.camera), rgb);
  if (is_packed_image(file_)) return packed_.unpack_rgb(file_, path, size_of(log_.camera), rgb);
  return png_.decode_rgb(file_, path, size_of(log_.camera), rgb);
}

}  // namespace g3d::hal
