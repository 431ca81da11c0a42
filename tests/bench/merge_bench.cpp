// SPDX-License-Identifier: Apache-2.0
// Two halves of one way, each mapped in a frame of its own, merged, against the map of the whole way; and how long
// merging takes.
//   merge_bench [--log FOLDER] [--frames N] [--trials N] [--resolution METRES] [--voxels MILLIONS]
//               [--threads N]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "hal/sim/seeded_random.hpp"
#include "mapper/align/map_aligner.hpp"
#include "mapper/align/pose_step.hpp"
#include "mapper/map_hash.hpp"
#include "mapper/merge.hpp"
#include "tests/support/look_around.hpp"
#include "tests/support/map_agreement.hpp"

using namespace g3d;

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

double seconds(const std::function<void()>& job) {
  const auto begin = std::chrono::steady_clock::now();
  job();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::unique_ptr<mapper::VoxelMap> merged(const mapper::VoxelMap& a, const mapper::VoxelMap& b,
                                         const hal::Pose& T_world_b, bool b_first = false, int threads = 1) {
  mapper::MergeOptions options;
  options.threads = threads;
  std::vector<mapper::MergeSource> sources{{&a, {}, 1}, {&b, T_world_b, 2}};
  if (b_first) std::reverse(sources.begin(), sources.end());
  auto result = mapper::merge_maps(sources, options);
  if (!result) {
    fmt::print(stderr, "merge_bench: {}\n", result.error().text);
    std::exit(1);
  }
  return std::move(result).value();
}

void report(const std::string& what, const mapper::VoxelMap& single, const mapper::VoxelMap& both) {
  const tests::Agreement there = tests::agreement(both, single);
  const tests::Agreement back = tests::agreement(single, both);
  fmt::print("  {:42s} within a voxel {:6.2f} / {:6.2f} %, by a face {:6.2f} / {:6.2f} %, occupied {} of {}\n", what,
             100.0 * there.beside(), 100.0 * back.beside(), 100.0 * there.by_face(), 100.0 * back.by_face(),
             both.counts().occupied, single.counts().occupied);
  std::fflush(stdout);
}

/// The second half's map stands at T_world_b; then the same, with a pose that is off and refined.
void halves(const test::Workload& work, float resolution_m, int perturbed) {
  const std::size_t half = work.frames.size() / 2;
  const auto single = test::map_in_own_frame(work, 0, work.frames.size(), resolution_m, {});
  const auto a = test::map_in_own_frame(work, 0, half, resolution_m, {});
  fmt::print("{}: {} frames at {:.2f} m; merged against single and single against merged\n", work.name,
             work.frames.size(), resolution_m);
  struct Frame {
    std::string name;
    hal::Pose T_world_b;
  };
  const std::vector<Frame> frames{
      {"in the same frame", {}},
      {"shifted by whole voxels", {{1.25, -0.6, 0.1}, {0, 0, 0, 1}}},
      {"turned by 37 degrees and shifted", hal::from_xyz_rpy(1.234, -0.777, 0.031, 0, 0, 37 * kDegree)},
      {"turned by 45 degrees, half a voxel", hal::from_xyz_rpy(0.025, 0.025, 0.025, 0, 0, 45 * kDegree)},
      {"rolled, pitched and turned", hal::from_xyz_rpy(-2.13, 0.456, 0.789, 0.35, -0.5, 2.1)}};
  for (const Frame& frame : frames) {
    const auto b = test::map_in_own_frame(work, half, work.frames.size(), resolution_m, hal::inverse(frame.T_world_b));
    const auto both = merged(a->map(), b->map(), frame.T_world_b);
    report(frame.name, single->map(), *both);
    if (mapper::map_hash(*both) != mapper::map_hash(*merged(a->map(), b->map(), frame.T_world_b, true))) {
      fmt::print("  DIFFERENT in the other order\n");
    }
  }
  // Robots begin upright; its frame is turned and shifted, and what is said of it is wrong by up to 0.3 m and 5
  // degrees.
  hal::SeededRandom random(7);
  const mapper::align::MapSurfaces surfaces_a(a->map());
  for (int trial = 0; trial < perturbed; ++trial) {
    const auto& start = work.frames[half].T_world_camera.translation_m;
    const hal::Pose T_world_b =
        hal::from_xyz_rpy(start[0], start[1], 0, 0, 0, 2.0 * std::numbers::pi * random.uniform());
    const double way = 2.0 * std::numbers::pi * random.uniform();
    const double off_m = 0.3 * random.uniform();
    const double off_rad = 5.0 * kDegree * (2.0 * random.uniform() - 1.0);
    const hal::Pose guess =
        hal::compose(T_world_b, hal::from_xyz_rpy(off_m * std::cos(way), off_m * std::sin(way), 0, 0, 0, off_rad));
    const auto b = test::map_in_own_frame(work, half, work.frames.size(), resolution_m, hal::inverse(T_world_b));
    const mapper::align::MapSurfaces surfaces_b(b->map());
    const auto found = align_maps(surfaces_a, surfaces_b, guess);
    const auto error = mapper::align::difference(T_world_b, found.T_a_b);
    report(fmt::format("off by {:.2f} m, {:+.1f} degrees: as said", off_m, off_rad / kDegree), single->map(),
           *merged(a->map(), b->map(), guess));
    report(fmt::format("  {}, still off {:.1f} mm, {:.2f} degrees", to_string(found.outcome),
                       1e3 * mapper::align::shift_of(error), mapper::align::turn_of(error) / kDegree),
           single->map(), *merged(a->map(), b->map(), found.T_a_b));
  }
}

/// A map of a cube of blocks: `dense_share` of them hold what surfaces leave, with colours, the others are free air.
std::unique_ptr<mapper::VoxelMap> made_up(std::uint32_t blocks, std::int32_t first_x, double dense_share) {
  auto map =
      std::make_unique<mapper::VoxelMap>(mapper::Grid{0.05F}, mapper::MapCapacity{blocks + 1, blocks + 1, 3 * blocks});
  const auto side = static_cast<std::int32_t>(std::ceil(std::cbrt(blocks)));
  hal::SeededRandom random(static_cast<std::uint64_t>(first_x));
  mapper::BlockValues values;
  for (std::uint32_t n = 0; n < blocks; ++n) {
    const auto i = static_cast<std::int32_t>(n);
    const mapper::VoxelIndex origin{32768 + 8 * (first_x + i % side), 32768 + 8 * (i / side % side),
                                    32768 + 8 * (i / side / side)};
    values.fill(2);
    if (random.uniform() < dense_share) {
      const auto salt = static_cast<std::uint32_t>(random.uniform() * 1e9);
      for (std::size_t k = 0; k < values.size(); ++k) values[k] = (salt >> (k % 29)) % 16;
      for (std::size_t k = 64; k < 150; ++k) {
        values[k] = mapper::make_rgbo(static_cast<std::uint8_t>(salt), 90, static_cast<std::uint8_t>(k), 24) |
                    mapper::kHasColourBit;
      }
    }
    (void)map->write_block(mapper::block_of(origin), values);
  }
  return map;
}

std::size_t bytes_of(const mapper::VoxelMap& map) {
  std::size_t bytes = 0;
  for (std::uint32_t slot = 0; slot < map.slot_end(); ++slot) {
    const mapper::BlockHeader& header = map.header(slot);
    bytes += sizeof header + (header.plane != mapper::kNoSlot ? sizeof(mapper::LevelPlane) : 0);
    for (const std::uint32_t brick : header.bricks) bytes += brick != mapper::kNoSlot ? sizeof(mapper::ColourBrick) : 0;
  }
  return bytes;
}

double copy_GBps() {
  std::vector<char> from(std::size_t{256} << 20, 1);
  std::vector<char> to(from.size(), 2);
  double best_s = 1e9;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t begin = std::clock();
    std::memcpy(to.data(), from.data(), from.size());
    best_s = std::min(best_s, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return 2.0 * static_cast<double>(from.size()) / best_s * 1e-9;
}

/// Two maps that overlap by half.
void speed(double millions, double dense_share, int threads, const std::string& what) {
  const auto blocks = static_cast<std::uint32_t>(millions * 1e6 / 2.0 / mapper::kBlockVoxels);
  const auto side = static_cast<std::int32_t>(std::ceil(std::cbrt(blocks)));
  const auto a = made_up(blocks, 0, dense_share);
  const auto b = made_up(blocks, side / 2, dense_share);
  const double known = static_cast<double>(a->counts().known() + b->counts().known());
  for (const auto& [how, T_world_b] : {std::pair<std::string, hal::Pose>{"in place", {}},
                                       {"shifted by whole voxels", {{0.15, 0.25, -0.05}, {0, 0, 0, 1}}},
                                       {"turned", hal::from_xyz_rpy(0.3, -0.4, 0.0, 0.02, 0.01, 0.3)}}) {
    std::unique_ptr<mapper::VoxelMap> both;
    const std::clock_t begin = std::clock();
    const double s = seconds([&] { both = merged(*a, *b, T_world_b, false, threads); });
    const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    const double bytes = static_cast<double>(bytes_of(*a) + bytes_of(*b) + bytes_of(*both));
    fmt::print(
        "{}, {}: {:.1f} million known voxels in {:.2f} s, {:.2f} s of CPU time: {:.0f} million a CPU second, maps of "
        "{:.2f} "
        "GB read and written at {:.2f} GB/s\n",
        what, how, known * 1e-6, s, cpu_s, known * 1e-6 / cpu_s, bytes * 1e-9, bytes / cpu_s * 1e-9);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t frames = 120;
  int trials = 3;
  int threads = 1;
  float resolution_m = 0.05F;
  double millions = 100.0;
  std::string log;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--frames") frames = static_cast<std::size_t>(std::atoi(argv[i + 1]));
    if (word == "--trials") trials = std::atoi(argv[i + 1]);
    if (word == "--threads") threads = std::atoi(argv[i + 1]);
    if (word == "--resolution") resolution_m = static_cast<float>(std::atof(argv[i + 1]));
    if (word == "--voxels") millions = std::atof(argv[i + 1]);
    if (word == "--log") log = argv[i + 1];
  }
  if (frames > 0) {
    halves(
        test::simulated_drive("furnished_room", static_cast<int>(frames), 60.0 / static_cast<double>(frames), 0.0, 320),
        resolution_m, trials);
    if (!log.empty()) {
      const test::Workload work = test::recorded(log, frames);
      if (work.frames.empty()) {
        fmt::print(stderr, "merge_bench: no frames in {}\n", log);
        return 1;
      }
      halves(work, resolution_m, trials);
    }
  }
  if (millions > 0.0) {
    fmt::print("copying takes {:.1f} GB/s, read and written\n", copy_GBps());
    speed(millions, 0.4, threads, "two blocks in five dense");
    speed(millions, 1.0, threads, "all dense");
  }
  return 0;
}
