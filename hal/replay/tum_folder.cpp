// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/tum_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/tum_lists.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kMaxCamera_bytes = 64 * 1024;
// Ten days at 30 Hz with long names.
constexpr std::size_t kMaxList_bytes = std::size_t{1} << 30;

bool exists(const std::string& path) { return ::access(path.c_str(), F_OK) == 0; }

Result<std::vector<ImageEntry>> read_image_list(const std::string& path) {
  const Result<std::string> text = read_text_file(path, kMaxList_bytes);
  if (!text) return text.error();
  return parse_image_list(text.value(), path);
}

Result<CameraModel> read_camera(const std::string& path, std::vector<std::string>& warnings) {
  if (!exists(path)) {
    warnings.push_back(fmt::format("{}: missing; TUM's defaults are taken (525 525 319.5 239.5 5000 640 480)", path));
    return tum_default_camera();
  }
  const Result<std::string> text = read_text_file(path, kMaxCamera_bytes);
  if (!text) return text.error();
  return parse_camera(text.value(), path);
}

Result<std::vector<ImageEntry>> read_colours(const std::string& path, std::vector<std::string>& warnings) {
  if (!exists(path)) {
    warnings.push_back(fmt::format("{}: missing; the map will have no colour", path));
    return std::vector<ImageEntry>();
  }
  Result<std::vector<ImageEntry>> colours = read_image_list(path);
  if (!colours) return colours;
  std::stable_sort(colours.value().begin(), colours.value().end(),
                   [](const ImageEntry& a, const ImageEntry& b) { return a.stamp_ns < b.stamp_ns; });
  return colours;
}

}  // namespace

Result<TumFolder> TumFolder::open(const std::string& folder) {
  TumFolder log;
  const Result<std::vector<ImageEntry>> depths = read_image_list(folder + "/depth.txt");
  if (!depths) {
    Error error = depths.error();
    if (error.reason == Reason::not_found) {
      error.text = fmt::format("{}: no recording: depth.txt is missing; give a folder in the TUM RGB-D layout", folder);
    }
    return error;
  }
  const Result<CameraModel> camera = read_camera(folder + "/camera.txt", log.warnings);
  if (!camera) return camera.error();
  log.camera = camera.value();
  const Result<std::vector<ImageEntry>> colours = read_colours(folder + "/rgb.txt", log.warnings);
  if (!colours) return colours.error();

  log.frames.reserve(depths.value().size());
  for (const ImageEntry& depth : depths.value()) {
    const auto colour = nearest_entry(colours.value(), depth.stamp_ns, kMaxColourDistance_ns);
    log.frames.push_back({depth.stamp_ns, folder + "/" + depth.file,
                          colour ? folder + "/" + colours.value()[*colour].file : std::string()});
  }
  return log;
}

Result<std::string> find_trajectory(const std::string& folder) {
  for (const char* const name : {"/trajectory.tum", "/groundtruth.txt"}) {
    if (exists(folder + name)) return folder + name;
  }
  return Error{Reason::not_found,
               fmt::format("{}: neither trajectory.tum nor groundtruth.txt is there; give a file of poses with --poses",
                           folder)};
}

}  // namespace g3d::hal
