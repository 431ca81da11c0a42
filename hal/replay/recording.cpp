// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "hal/image/file_bytes.hpp"
#include "hal/image/image_size.hpp"
#include "hal/replay/decimal.hpp"
#include "hal/replay/tum_lists.hpp"

namespace g3d::hal {
namespace {

constexpr double kLargestFootprint_m = 10.0;
constexpr double kFarthest_m = 1e6;
constexpr std::size_t kMostReasons = 64;

std::optional<RecordedFootprint> parse_footprint(std::string_view rest) {
  std::array<double, 5> numbers{};
  for (double& number : numbers) {
    const auto parsed = parse_double(take_word(rest));
    if (!parsed || !(std::abs(*parsed) <= kFarthest_m)) return std::nullopt;
    number = *parsed;
  }
  const auto is_size = [](double m) { return m > 0.0 && m <= kLargestFootprint_m; };
  if (!rest.empty() || !is_size(numbers[3]) || !is_size(numbers[4])) return std::nullopt;
  return RecordedFootprint{{numbers[0], numbers[1], numbers[2]}, numbers[3], numbers[4]};
}

bool is_hash(std::string_view text) {
  return text.size() == 64 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
}

/// False if the line is none of those.
bool take_line(std::string_view line, MappedLog& log) {
  const std::string_view all = line;
  const std::string_view what = take_word(line);
  if (what == "footprint") {
    log.footprint = parse_footprint(line);
    return log.footprint.has_value();
  }
  if (what == "masked") {
    // The list reader knows what a stamp is and which names stay in the folder.
    const auto entry = parse_image_list(all.substr(all.find("masked") + what.size()), "");
    if (!entry || entry.value().size() != 1) return false;
    log.masked[entry.value().front().stamp_ns] = entry.value().front().file;
    return true;
  }
  if (what == "colour") {
    log.with_colour = line != "no";
    return line == "no" || line == "yes";
  }
  if (what == "cannot") {
    if (log.cannot.size() < kMostReasons) log.cannot.emplace_back(line);
    return !line.empty();
  }
  if (what != "map" || !is_hash(line)) return false;
  log.hash = line;
  return true;
}

}  // namespace

Result<MappedLog> parse_mapped_log(std::string_view text, std::string_view name) {
  text = text.substr(0, text.rfind('\n') + 1);  // npos + 1 is 0
  MappedLog log;
  LineReader lines(text);
  while (const auto line = lines.next()) {
    if (take_line(*line, log)) continue;
    return Error{Reason::malformed,
                 fmt::format("{}:{}: not a line of a recording; expected: footprint, masked, colour, "
                             "cannot or map",
                             name, lines.line_number())};
  }
  return log;
}

PoseStatus ExactPoses::pose_at(TimeNs stamp_ns, Pose& T_world_camera) const {
  const auto found = std::lower_bound(poses_.begin(), poses_.end(), stamp_ns,
                                      [](const StampedPose& pose, TimeNs stamp) { return pose.stamp_ns < stamp; });
  if (found == poses_.end() || found->stamp_ns != stamp_ns) return PoseStatus::not_known;
  if (!is_valid(found->T_world_camera)) return PoseStatus::invalid;
  T_world_camera = found->T_world_camera;
  return PoseStatus::ok;
}

CameraRead MaskedCamera::read(Frame& out) {
  const CameraRead read = camera_.read(out);
  if (read.event != CameraEvent::frame) return read;
  const auto masked = masked_.find(out.stamp_ns);
  if (masked == masked_.end()) return read;
  const std::string path = folder_ + "/" + masked->second;
  const CameraModel& camera = model();
  Result<void> taken = read_file_into(path, kMaxImageFile_bytes, file_);
  if (taken) {
    taken = unpacker_.unpack_depth(file_, path, {camera.width_px, camera.height_px},
                                   std::span(out.depth.get(), camera.pixel_count()));
  }
  if (taken) return read;
  last_error_ = taken.error().text;
  return {CameraEvent::dropped, DropReason::unreadable_depth};
}

}  // namespace g3d::hal
