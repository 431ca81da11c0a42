// SPDX-License-Identifier: Apache-2.0
#include "tests/support/log_folder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "hal/geometry.hpp"
#include "hal/image/png_writer.hpp"

namespace g3d::test {
namespace {

constexpr double kFirstStamp_s = 1305031229.5;

void must(const hal::Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().text);
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  if (!file) throw std::runtime_error("cannot write " + path);
}

std::string pose_line(const LogSpec& spec, double frame) {
  const hal::Pose pose = hal::look_at({0.0, 0.01 * frame, 1.0}, {2.0, 0.01 * frame, 1.0});
  return fmt::format("{:.6f} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n", kFirstStamp_s + frame * spec.period_s,
                     pose.translation_m[0], pose.translation_m[1], pose.translation_m[2], pose.rotation_xyzw[0],
                     pose.rotation_xyzw[1], pose.rotation_xyzw[2], pose.rotation_xyzw[3]);
}

}  // namespace

std::string log_stamp(const LogSpec& spec, int frame) {
  return fmt::format("{:.6f}", kFirstStamp_s + frame * spec.period_s);
}

std::string log_depth_path(const std::string& folder, int frame) {
  return fmt::format("{}/depth/{:04}.png", folder, frame);
}

void write_log(const std::string& folder, const LogSpec& spec) {
  std::filesystem::create_directories(folder + "/depth");
  std::filesystem::create_directories(folder + "/rgb");
  const hal::ImageSize size{spec.width_px, spec.height_px};
  const auto pixels = static_cast<std::size_t>(spec.width_px) * static_cast<std::size_t>(spec.height_px);
  std::vector<std::uint16_t> depth(pixels);
  std::vector<std::uint8_t> rgb(3 * pixels);
  std::string depth_list = "# timestamp filename\n", rgb_list = depth_list;
  std::string poses = "# timestamp tx ty tz qx qy qz qw\n" + pose_line(spec, -1.0);
  for (int frame = 0; frame < spec.frames; ++frame) {
    for (std::size_t i = 0; i < pixels; ++i) {
      const auto u = i % static_cast<std::size_t>(spec.width_px);
      depth[i] = static_cast<std::uint16_t>(i % 97 == 0 ? 0 : 10000 + 40 * (u % 16));  // 2.00..2.12 m, some holes
      rgb[3 * i] = static_cast<std::uint8_t>(4 * u);
      rgb[3 * i + 1] = 128;
      rgb[3 * i + 2] = static_cast<std::uint8_t>(i / static_cast<std::size_t>(spec.width_px));
    }
    must(hal::write_png_depth(log_depth_path(folder, frame), size, depth));
    depth_list += fmt::format("{} depth/{:04}.png\n", log_stamp(spec, frame), frame);
    if (spec.with_colour) {
      must(hal::write_png_rgb(fmt::format("{}/rgb/{:04}.png", folder, frame), size, rgb));
      rgb_list += fmt::format("{} rgb/{:04}.png\n", log_stamp(spec, frame), frame);
    }
    poses += pose_line(spec, frame);
  }
  poses += pose_line(spec, spec.frames);
  write_text(folder + "/depth.txt", depth_list);
  if (spec.with_colour) write_text(folder + "/rgb.txt", rgb_list);
  write_text(folder + "/groundtruth.txt", poses);
  write_text(folder + "/camera.txt",
             fmt::format("# fx fy cx cy depth_units_per_metre width height\n{} {} {} {} 5000 {} {}\n",
                         0.82 * spec.width_px, 0.82 * spec.width_px, (spec.width_px - 1) / 2.0,
                         (spec.height_px - 1) / 2.0, spec.width_px, spec.height_px));
}

void replace_log_line(const std::string& path, int frame, const std::string& line) {
  std::ifstream in(path);
  std::string text, current;
  for (int i = -1; std::getline(in, current); ++i) text += (i == frame ? line : current) + "\n";
  write_text(path, text);
}

}  // namespace g3d::test
