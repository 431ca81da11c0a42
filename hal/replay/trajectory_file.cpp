// SPDX-License-Identifier: Apache-2.0
#include "hal/replay/trajectory_file.hpp"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "hal/image/file_bytes.hpp"
#include "hal/replay/decimal.hpp"

namespace g3d::hal {
namespace {

constexpr std::string_view kHeader = "# stamp_s tx_m ty_m tz_m qx qy qz qw (T_world_camera)\n";

std::optional<StampedPose> parse_pose_line(std::string_view line) {
  const std::optional<TimeNs> stamp_ns = parse_stamp_ns(take_word(line));
  if (!stamp_ns) return std::nullopt;
  StampedPose pose;
  pose.stamp_ns = *stamp_ns;
  for (std::size_t i = 0; i < 7; ++i) {
    const std::optional<double> number = parse_double(take_word(line));
    if (!number) return std::nullopt;
    (i < 3 ? pose.T_world_camera.translation_m[i] : pose.T_world_camera.rotation_xyzw[i - 3]) = *number;
  }
  if (!line.empty()) return std::nullopt;
  return pose;
}

}  // namespace

Result<std::vector<StampedPose>> parse_trajectory(std::string_view text, std::string_view name) {
  std::vector<StampedPose> poses;
  LineReader lines(text);
  while (const auto line = lines.next()) {
    const std::optional<StampedPose> pose = parse_pose_line(*line);
    if (!pose) {
      return Error{Reason::malformed,
                   fmt::format("{}:{}: not a pose; expected: stamp tx ty tz qx qy qz qw", name, lines.line_number())};
    }
    if (!poses.empty() && pose->stamp_ns < poses.back().stamp_ns) {
      return Error{Reason::malformed,
                   fmt::format("{}:{}: stamp {} is earlier than {} before it; sort the file by time", name,
                               lines.line_number(), format_stamp(pose->stamp_ns), format_stamp(poses.back().stamp_ns))};
    }
    poses.push_back(*pose);
  }
  return poses;
}

Result<std::vector<StampedPose>> read_trajectory(const std::string& path) {
  const Result<std::string> text = read_text_file(path, kMaxTrajectory_bytes);
  if (!text) return text.error();
  return parse_trajectory(text.value(), path);
}

std::string_view format_pose_line(const StampedPose& pose, PoseLine& buffer) {
  const auto& t = pose.T_world_camera.translation_m;
  const auto& q = pose.T_world_camera.rotation_xyzw;
  char* end = format_stamp_to(buffer.data(), pose.stamp_ns);
  // Seven doubles of at most 24 characters each: the buffer has room for all of them.
  end = fmt::format_to(end, " {} {} {} {} {} {} {}\n", t[0], t[1], t[2], q[0], q[1], q[2], q[3]);
  return {buffer.data(), static_cast<std::size_t>(end - buffer.data())};
}

std::string format_pose_line(const StampedPose& pose) {
  PoseLine buffer;
  return std::string(format_pose_line(pose, buffer));
}

Result<void> TrajectoryWriter::append(const StampedPose& pose) {
  PoseLine buffer;
  return file_.write(format_pose_line(pose, buffer));
}

Result<TrajectoryWriter> TrajectoryWriter::create(const std::string& path) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();
  if (Result<void> written = file.value().write(kHeader); !written) return written.error();
  return TrajectoryWriter(std::move(file).value());
}

Result<void> write_trajectory(const std::string& path, std::span<const StampedPose> poses) {
  Result<TrajectoryWriter> writer = TrajectoryWriter::create(path);
  if (!writer) return writer.error();
  for (const StampedPose& pose : poses) {
    if (Result<void> written = writer.value().append(pose); !written) return written;
  }
  return writer.value().commit();
}

}  // namespace g3d::hal
