// SPDX-License-Identifier: Apache-2.0
// How far the projective map is from the exact one over a whole run: voxels whose state differs, occupied voxels lost.
//   agreement_bench [--frames N] [--step SECONDS] [--resolution METRES] [--world NAME | --log FOLDER]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>

#include "mapper/mapper.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

struct Agreement {
  std::uint64_t known = 0;  ///< to either
  std::uint64_t differ = 0;
  std::uint64_t occupied = 0;       ///< in the exact map
  std::uint64_t occupied_lost = 0;  ///< of those, not occupied in the other
  std::uint64_t table[3][3] = {};   ///< [exact][other]
};

Agreement compare(const mapper::VoxelMap& exact, const mapper::VoxelMap& other) {
  Agreement a;
  std::vector<mapper::BlockKey> keys = exact.sorted_keys();
  const std::vector<mapper::BlockKey> more = other.sorted_keys();
  keys.insert(keys.end(), more.begin(), more.end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  mapper::BlockValues x;
  mapper::BlockValues y;
  for (const mapper::BlockKey key : keys) {
    exact.read_block(key, x);
    other.read_block(key, y);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const auto sx = mapper::state_of(x[i]);
      const auto sy = mapper::state_of(y[i]);
      ++a.table[static_cast<int>(sx)][static_cast<int>(sy)];
      if (sx == mapper::State::unknown && sy == mapper::State::unknown) continue;
      ++a.known;
      a.differ += sx != sy;
      a.occupied += sx == mapper::State::occupied;
      a.occupied_lost += sx == mapper::State::occupied && sy != mapper::State::occupied;
    }
  }
  return a;
}

void run(const test::Workload& work, float resolution_m) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.with_colour = false;
  config.capacity = mapper::capacity_for_bytes(std::size_t{1536} << 20);
  config.integrator = mapper::IntegratorKind::dda;
  mapper::Mapper exact(config, work.camera);
  config.integrator = mapper::IntegratorKind::projective;
  mapper::Mapper projective(config, work.camera);
  for (const test::PosedImage& image : work.frames) {
    (void)exact.integrate(image.frame, image.T_world_camera);
    (void)projective.integrate(image.frame, image.T_world_camera);
  }
  const Agreement a = compare(exact.map(), projective.map());
  const double percent = 100.0 / static_cast<double>(a.known);
  fmt::print(
      "{:24} r={:.3f} frames={} known={} differ={:.3f}% (free->unknown {:.3f}% unknown->free {:.3f}% free->occ {:.3f}%"
      " occ->free {:.3f}% unk->occ {:.3f}%) occupied lost {:.3f}%\n",
      work.name, resolution_m, work.frames.size(), a.known, percent * static_cast<double>(a.differ),
      percent * static_cast<double>(a.table[1][0]), percent * static_cast<double>(a.table[0][1]),
      percent * static_cast<double>(a.table[1][2]), percent * static_cast<double>(a.table[2][1]),
      percent * static_cast<double>(a.table[0][2]),
      100.0 * static_cast<double>(a.occupied_lost) / static_cast<double>(std::max<std::uint64_t>(a.occupied, 1)));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 60;
  double step_s = 1.0;
  std::string world = "furnished_room";
  std::string log;
  std::vector<float> resolutions_m;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--frames") == 0) frames = std::atoi(argv[i + 1]);
    if (std::strcmp(argv[i], "--step") == 0) step_s = std::atof(argv[i + 1]);
    if (std::strcmp(argv[i], "--resolution") == 0) resolutions_m.push_back(static_cast<float>(std::atof(argv[i + 1])));
    if (std::strcmp(argv[i], "--world") == 0) world = argv[i + 1];
    if (std::strcmp(argv[i], "--log") == 0) log = argv[i + 1];
  }
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F, 0.01F};
  const test::Workload work = log.empty() ? test::simulated_drive(world, frames, step_s)
                                          : test::recorded(log, static_cast<std::size_t>(frames));
  if (work.frames.empty()) {
    fmt::print(stderr, "agreement_bench: no frames in {}\n", log.empty() ? world : log);
    return 1;
  }
  for (const float r : resolutions_m) run(work, r);
  return 0;
}
