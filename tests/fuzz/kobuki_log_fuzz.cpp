// SPDX-License-Identifier: Apache-2.0
// `kobuki.bin` from hostile hands: whatever is accepted is written and read again without a difference, and its
// odometry is the same when it is computed twice.
#include <cstdlib>

#include "hal/replay/recorded_odometry.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size_bytes) {
  using namespace g3d::hal;
  std::vector<std::uint8_t> file(data, data + size_bytes);
  const Result<KobukiLog> log = KobukiLog::parse(file, "fuzz.bin");
  if (!log) return 0;
  std::vector<std::uint8_t> written;
  for (auto records = log.value().records(); records.peek(); records.advance()) {
    append_record(written, records.peek()->t_ns, records.peek()->bytes);
  }
  file.resize(file.size() - log.value().torn_bytes());
  if (written != file) std::abort();

  const RecordedOdometry first = recompute_odometry(log.value(), Pose{});
  const RecordedOdometry second = recompute_odometry(log.value(), Pose{});
  if (!(first.T_world_base == second.T_world_base) || first.poses.size() != second.poses.size()) std::abort();
  for (std::size_t i = 0; i < first.poses.size(); ++i) {
    if (!is_valid(first.poses[i].T_world_camera)) std::abort();
    if (i > 0 && first.poses[i].stamp_ns <= first.poses[i - 1].stamp_ns) std::abort();
  }
  return 0;
}
