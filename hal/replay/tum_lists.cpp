// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/tum_lists.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

constexpr std::size_t kMaxFileName_bytes = 1024;
constexpr double kMinFocalLength_px = 1;
constexpr double kMaxFocalLength_px = 100'000;
constexpr double kMaxDepthUnitsPerMetre = 1'000'000;

// NaN is outside of every range.
bool within(double value, double min, double max) { return value >= min && value <= max; }

bool stays_inside(std::string_view file) {
  if (file.empty() || file.size() > kMaxFileName_bytes || file.front() == '/') return false;
  if (std::any_of(file.begin(), file.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; })) return false;
  for (std::string_view rest = file; !rest.empty();) {
    const std::size_t slash = rest.find('/');
    if (rest.substr(0, slash) == "..") return false;
    rest = slash == std::string_view::npos ? std::string_view() : rest.substr(slash + 1);
  }
  return true;
}

struct CameraLine {
  double fx_px, fy_px, cx_px, cy_px, depth_units_per_metre;
  int width_px, height_px;
};

std::optional<CameraLine> split_camera_line(std::string_view line) {
  double numbers[5];
  for (double& number : numbers) {
    const std::optional<double> parsed = parse_double(take_word(line));
    if (!parsed) return std::nullopt;
    number = *parsed;
  }
  const std::optional<int> width_px = parse_int(take_word(line));
  const std::optional<int> height_px = parse_int(take_word(line));
  if (!width_px || !height_px || !line.empty()) return std::nullopt;
  return CameraLine{numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], *width_px, *height_px};
}

// What is wrong with it, or nullptr.
const char* complaint_about(const CameraLine& camera) {
  if (camera.width_px < 1 || camera.height_px < 1 || camera.width_px > kMaxImageSide_px ||
      camera.height_px > kMaxImageSide_px) {
    return "width and height must be 1 to 2048 pixels";
  }
  if (!within(camera.fx_px, kMinFocalLength_px, kMaxFocalLength_px) ||
      !within(camera.fy_px, kMinFocalLength_px, kMaxFocalLength_px)) {
    return "fx and fy must be 1 to 100000 pixels";
  }
  if (!within(camera.cx_px, -camera.width_px, 2.0 * camera.width_px) ||
      !within(camera.cy_px, -camera.height_px, 2.0 * camera.height_px)) {
    return "cx and cy must be near the image";
  }
  if (!within(camera.depth_units_per_metre, 1, kMaxDepthUnitsPerMetre)) {
    return "depth units per metre must be 1 to 1000000";
  }
  return nullptr;
}

}  // namespace

CameraModel tum_default_camera() {
  CameraModel model;
  model.width_px = 640;
  model.height_px = 480;
  model.fx_px = 525.0F;
  model.fy_px = 525.0F;
  model.cx_px = 319.5F;
  model.cy_px = 239.5F;
  model.depth_units_per_metre = 5000.0F;
  return model;
}

Result<CameraModel> parse_camera(std::string_view text, std::string_view name) {
  constexpr const char* kExpected = "expected one line: fx fy cx cy depth_units_per_metre width height";
  LineReader lines(text);
  const auto line = lines.next();
  if (!line) return Error{Reason::truncated, fmt::format("{}: holds no line; {}", name, kExpected)};
  const std::optional<CameraLine> camera = split_camera_line(*line);
  if (!camera) {
    return Error{Reason::malformed, fmt::format("{}:{}: not a camera; {}", name, lines.line_number(), kExpected)};
  }
  if (const char* const complaint = complaint_about(*camera)) {
    return Error{Reason::out_of_range, fmt::format("{}:{}: {}; {}", name, lines.line_number(), complaint, kExpected)};
  }
  if (lines.next()) {
    return Error{Reason::malformed, fmt::format("{}:{}: a second camera; {}", name, lines.line_number(), kExpected)};
  }
  CameraModel model;
  model.width_px = camera->width_px;
  model.height_px = camera->height_px;
  model.fx_px = static_cast<float>(camera->fx_px);
  model.fy_px = static_cast<float>(camera->fy_px);
  model.cx_px = static_cast<float>(camera->cx_px);
  model.cy_px = static_cast<float>(camera->cy_px);
  model.depth_units_per_metre = static_cast<float>(camera->depth_units_per_metre);
  return model;
}

Result<std::vector<ImageEntry>> parse_image_list(std::string_view text, std::string_view name) {
  std::vector<ImageEntry> entries;
  LineReader lines(text);
  while (const auto line = lines.next()) {
    std::string_view rest = *line;
    const std::optional<TimeNs> stamp_ns = parse_stamp_ns(take_word(rest));
    if (!stamp_ns || rest.empty()) {
      return Error{Reason::malformed,
                   fmt::format("{}:{}: not an image; expected: stamp file", name, lines.line_number())};
    }
    if (!stays_inside(rest)) {
      return Error{Reason::malformed, fmt::format("{}:{}: the file name leaves the folder or is no name; use a "
                                                  "relative path without ..",
                                                  name, lines.line_number())};
    }
    entries.push_back({*stamp_ns, std::string(rest)});
  }
  return entries;
}

std::optional<std::size_t> nearest_entry(std::span<const ImageEntry> sorted, TimeNs stamp_ns, TimeNs max_distance_ns) {
  const auto after = std::lower_bound(sorted.begin(), sorted.end(), stamp_ns,
                                      [](const ImageEntry& entry, TimeNs stamp) { return entry.stamp_ns < stamp; });
  const auto index = static_cast<std::size_t>(after - sorted.begin());
  std::optional<std::size_t> nearest;
  TimeNs distance_ns = max_distance_ns;
  if (index > 0 && stamp_ns - sorted[index - 1].stamp_ns <= distance_ns) {
    nearest = index - 1;
    distance_ns = stamp_ns - sorted[index - 1].stamp_ns - 1;
  }
  if (index < sorted.size() && sorted[index].stamp_ns - stamp_ns <= distance_ns) nearest = index;
  return nearest;
}

}  // namespace g3d::hal
