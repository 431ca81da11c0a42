// SPDX-License-Identifier: Apache-2.0
// Does a frame cost more in a large map? The same drive again and again, each lap in a place of its own where nothing
// is known yet, until the card holds more than a hundred million known voxels.
#pragma once

#include <fstream>

#include "tests/bench/gpu_rig.hpp"

namespace g3d::bench {

/// On the lattice of blocks for all of our resolutions, and farther than one lap sees.
inline constexpr double kLapShift_m = 16.0;
inline constexpr int kLapsInARow = 8;
inline constexpr int kLeastLaps = 12;
inline constexpr int kMostLaps = 40;  // at 1 cm they fit into 16 bits per axis
inline constexpr std::uint64_t kEnoughVoxels = 120'000'000;
inline constexpr std::size_t kGrowthMap_bytes = std::size_t{3} << 30;

inline hal::Pose in_lap(hal::Pose pose, int lap) {
  pose.translation_m[0] += kLapShift_m * (lap % kLapsInARow - kLapsInARow / 2);
  pose.translation_m[1] += kLapShift_m * (lap / kLapsInARow - kLapsInARow / 2);
  return pose;
}

/// Memory that the system can give without swapping.
inline std::size_t available_bytes() {
  std::ifstream file("/proc/meminfo");
  for (std::string word; file >> word;) {
    std::size_t kilobytes = 0;
    if (word == "MemAvailable:" && file >> kilobytes) return kilobytes << 10;
  }
  return 0;
}

/// Medians of a lap's frames, and what the map holds after it.
struct Lap {
  double card_us = 0.0;
  double classes_us = 0.0;
  std::uint64_t known = 0;
};

inline Lap drive_lap(Rig& rig, const test::Workload& work, int number, std::uint64_t& refused) {
  std::vector<double> card_us;
  std::vector<double> classes_us;
  for (const auto& [frame, pose] : work.frames) {
    refused += rig.integrate(frame, in_lap(pose, number)).refused_blocks;
    card_us.push_back(static_cast<double>(rig.helper->stages_us()[0]));
    classes_us.push_back(static_cast<double>(rig.helper->stages_us()[1]));
  }
  return {median(card_us), median(classes_us), rig.map.counts().known()};
}

inline void measure_growth(MapperConfig config, const test::Workload& work) {
  const std::string name = title(config, work);
  if (const std::size_t bytes = available_bytes(); bytes < kGrowthMap_bytes) {
    fmt::print("growth  {}: this machine has {} MB to spare, the map's mirror needs {} FAILED\n", name, bytes >> 20,
               kGrowthMap_bytes >> 20);
    ++failures;
    return;
  }
  config.capacity = capacity_for_bytes(kGrowthMap_bytes);
  Rig rig(config, work.camera);
  if (!rig.twin.has_card()) {
    ++failures;
    return;
  }
  rig.helper->set_frame_command(cuda::HelperCommand::run_frame_timed);
  std::vector<Lap> laps;
  std::uint64_t refused = 0;
  const int failures_before = failures;
  const auto goes_on = [&] {
    const auto count = static_cast<int>(laps.size());
    const bool enough = count >= kLeastLaps && laps.back().known >= kEnoughVoxels;
    return failures == failures_before && refused == 0 && !enough && count < kMostLaps;
  };
  while (goes_on()) {
    laps.push_back(drive_lap(rig, work, static_cast<int>(laps.size()), refused));
    fmt::print("growth  {}: lap {}, {:.1f} million known voxels in {} blocks, card {:.1f} us, classes back {:.1f} us\n",
               name, laps.size(), static_cast<double>(laps.back().known) * 1e-6, rig.map.block_count(),
               laps.back().card_us, laps.back().classes_us);
    std::fflush(stdout);
  }
  std::vector<double> last_us;
  for (std::size_t i = laps.size() - std::min<std::size_t>(laps.size(), 3); i < laps.size(); ++i) {
    last_us.push_back(laps[i].card_us);
  }
  const bool good = failures == failures_before && refused == 0 && laps.back().known >= kEnoughVoxels;
  failures += good || failures != failures_before ? 0 : 1;
  fmt::print("growth  {}: {:.1f} million known voxels, {} refused blocks, last laps / second lap {:.2f} {}\n", name,
             static_cast<double>(laps.back().known) * 1e-6, refused,
             laps.size() < 2 ? 0.0 : median(last_us) / std::max(laps[1].card_us, 1e-3), good ? "ok" : "FAILED");
  std::fflush(stdout);
}

}  // namespace g3d::bench
