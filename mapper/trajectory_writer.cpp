// SPDX-License-Identifier: Apache-2.0
#include "mapper/trajectory_writer.hpp"

#include <fmt/format.h>

#include <utility>

namespace g3d::mapper {

std::string_view format_trajectory_line(hal::TimeNs stamp_ns, const hal::Pose& pose, TrajectoryLine& buffer) {
  // Integers, because a double holds today's seconds only to 0.2 microseconds.
  const auto magnitude_ns =
      stamp_ns < 0 ? 0 - static_cast<std::uint64_t>(stamp_ns) : static_cast<std::uint64_t>(stamp_ns);
  const auto& t = pose.translation_m;
  const auto& q = pose.rotation_xyzw;
  const auto end =
      fmt::format_to_n(buffer.data(), buffer.size(), "{}{}.{:09} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                       stamp_ns < 0 ? "-" : "", magnitude_ns / 1'000'000'000, magnitude_ns % 1'000'000'000, t[0], t[1],
                       t[2], q[0], q[1], q[2], q[3]);
  return {buffer.data(), static_cast<std::size_t>(end.out - buffer.data())};
}

hal::Result<TrajectoryWriter> TrajectoryWriter::create(const std::string& path) {
  auto file = hal::AtomicFile::create(path);
  if (!file) return file.error();
  TrajectoryWriter writer(std::move(file).value());
  const auto header = writer.file_.write("# timestamp_s tx_m ty_m tz_m qx qy qz qw, T_world_camera\n");
  if (!header) return header.error();
  return writer;
}

TrajectoryWriter::TrajectoryWriter(hal::AtomicFile file) : file_(std::move(file)) {}

void TrajectoryWriter::add(hal::TimeNs stamp_ns, const hal::Pose& T_world_camera) {
  if (!first_failure_) return;
  TrajectoryLine line;
  auto written = file_.write(format_trajectory_line(stamp_ns, T_world_camera, line));
  if (!written) first_failure_ = std::move(written);
}

hal::Result<void> TrajectoryWriter::finish() {
  if (!first_failure_) return first_failure_;
  return file_.commit();
}

}  // namespace g3d::mapper
