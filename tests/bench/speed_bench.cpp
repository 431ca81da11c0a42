// SPDX-License-Identifier: Apache-2.0
// Time of one frame, points and pose in, map updated out: liboctomap and our integrators in turn on the same frame, one
// thread each, and the projective one on two. Medians over the frames after the first five, and the ratio frame by
// frame.
//   speed_bench [--resolution METRES]... [--frames N] [--step SECONDS] [--start SECONDS] [--log FOLDER] [--no-octomap]
//   [--cpu-time]
// The first thing it does is to use and give back the memory that the maps will grow into: on a virtual machine the
// host provides a page when it is touched for the first time ever, which takes longer than mapping, and hits whoever is
// first.
#include <fmt/format.h>
#include <octomap/octomap.h>
#include <sys/mman.h>
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "mapper/mapper.hpp"
#include "tests/support/ray_list.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;

namespace {

constexpr std::size_t kWarmUp_frames = 5;

bool use_cpu_time = false;

// Wall time, or the thread's own time: on a machine that others use too only the latter says what the work costs. It
// cannot compare runs with several threads.
double now_ms() {
  timespec t{};
  clock_gettime(use_cpu_time ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

struct Spread {
  double min = 0;
  double median = 0;
  double max = 0;
};
Spread spread(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 2], values.back()};
}

// Far readings end at 3.5 m for both. OctoMap is given these ends as points: the same rays, its own unchanged function.
double octomap_frame_ms(octomap::OcTree& tree, const test::RayList& rays) {
  octomap::Pointcloud cloud;
  cloud.reserve(rays.hits_m.size() + rays.far_m.size());
  for (const auto& p : rays.hits_m) cloud.push_back(p[0], p[1], p[2]);
  for (const auto& p : rays.far_m) cloud.push_back(p[0], p[1], p[2]);
  const octomap::point3d origin(rays.origin_m[0], rays.origin_m[1], rays.origin_m[2]);
  const double start_ms = now_ms();
  tree.insertPointCloud(cloud, origin, -1.0, false, true);
  return now_ms() - start_ms;
}

void have_memory_provided() {
  constexpr std::size_t kBytes = std::size_t{2} << 30;
  void* const place = mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) return;
  auto* const bytes = static_cast<volatile char*>(place);
  for (std::size_t i = 0; i < kBytes; i += 4096) bytes[i] = 1;
  munmap(place, kBytes);
}

struct Contestant {
  std::string name;
  std::unique_ptr<mapper::Mapper> mapper;
  std::vector<double> times_ms;
};

void run(const test::Workload& work, float resolution_m, bool with_octomap) {
  mapper::MapperConfig config;
  config.resolution_m = resolution_m;
  config.capacity = mapper::capacity_for_bytes(std::size_t{1024} << 20);
  std::vector<Contestant> contestants;
  const auto enter = [&](const char* name, mapper::IntegratorKind kind, int threads) {
    config.integrator = kind;
    config.threads = threads;
    contestants.push_back({name, std::make_unique<mapper::Mapper>(config, work.camera), {}});
  };
  enter("projective", mapper::IntegratorKind::projective, 1);
  enter("dda", mapper::IntegratorKind::dda, 1);
  enter("bresenham", mapper::IntegratorKind::bresenham, 1);
  enter("projective x2", mapper::IntegratorKind::projective, 2);
  octomap::OcTree tree(resolution_m);
  std::vector<double> octomap_ms;
  for (std::size_t i = 0; i < work.frames.size(); ++i) {
    const test::PosedImage& image = work.frames[i];
    if (with_octomap) {
      const double ms =
          octomap_frame_ms(tree, test::ray_list(work.camera, image.frame.depth.get(), image.T_world_camera));
      if (i >= kWarmUp_frames) octomap_ms.push_back(ms);
    }
    for (Contestant& contestant : contestants) {
      const double start_ms = now_ms();
      (void)contestant.mapper->integrate(image.frame, image.T_world_camera);
      const double ms = now_ms() - start_ms;
      if (i >= kWarmUp_frames) contestant.times_ms.push_back(ms);
    }
  }
  fmt::print("{} r={:.3f} m, {} frames\n", work.name, resolution_m, work.frames.size());
  const auto line = [](const char* name, const Spread& t) {
    fmt::print("  {:14} ms/frame min {:9.3f} median {:9.3f} max {:9.3f}", name, t.min, t.median, t.max);
  };
  if (with_octomap) {
    line("OctoMap", spread(octomap_ms));
    fmt::print("\n");
  }
  for (const Contestant& contestant : contestants) {
    line(contestant.name.c_str(), spread(contestant.times_ms));
    const auto ratio_to = [&](const std::vector<double>& other_ms) {
      std::vector<double> ratios;
      for (std::size_t i = 0; i < other_ms.size(); ++i) ratios.push_back(other_ms[i] / contestant.times_ms[i]);
      return spread(ratios);
    };
    if (with_octomap) {
      const Spread r = ratio_to(octomap_ms);
      fmt::print("   x OctoMap min {:7.1f} median {:7.1f} max {:7.1f}", r.min, r.median, r.max);
    }
    if (contestant.name == "projective x2")
      fmt::print("   x one thread median {:.2f}", ratio_to(contestants[0].times_ms).median);
    fmt::print("\n");
  }
  const mapper::MapCounts counts = contestants[0].mapper->map().counts();
  fmt::print(
      "  projective map: {} known, {} occupied, {:.2f} bytes per known voxel with colour\n", counts.known(),
      counts.occupied,
      static_cast<double>(contestants[0].mapper->map().memory().used_bytes) / static_cast<double>(counts.known()));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 60;
  double start_s = 0.0;
  double step_s = 0.0;  // 0: spread over the whole minute's drive
  std::string log;
  bool with_octomap = true;
  std::vector<float> resolutions_m;
  for (int i = 1; i < argc; ++i) {
    const bool has_value = i + 1 < argc;
    if (std::strcmp(argv[i], "--cpu-time") == 0) {
      use_cpu_time = true;
    } else if (std::strcmp(argv[i], "--no-octomap") == 0) {
      with_octomap = false;
    } else if (std::strcmp(argv[i], "--frames") == 0 && has_value) {
      frames = std::atoi(argv[++i]);
    } else if (std::strcmp(argv[i], "--step") == 0 && has_value) {
      step_s = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--start") == 0 && has_value) {
      start_s = std::atof(argv[++i]);
    } else if (std::strcmp(argv[i], "--resolution") == 0 && has_value) {
      resolutions_m.push_back(static_cast<float>(std::atof(argv[++i])));
    } else if (std::strcmp(argv[i], "--log") == 0 && has_value) {
      log = argv[++i];
    } else {
      fmt::print(
          stderr,
          "speed_bench: {}: not understood; options are --resolution METRES, --frames N, --step SECONDS, --start "
          "SECONDS, --log FOLDER, --no-octomap and --cpu-time\n",
          argv[i]);
      return 2;
    }
  }
  have_memory_provided();
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F, 0.01F};
  const test::Workload work =
      log.empty() ? test::simulated_drive("furnished_room", frames, step_s > 0.0 ? step_s : 60.0 / frames, start_s)
                  : test::recorded(log, static_cast<std::size_t>(frames));
  if (work.frames.size() <= kWarmUp_frames) {
    fmt::print(stderr, "speed_bench: {} has {} frames, more than {} are needed\n", work.name, work.frames.size(),
               kWarmUp_frames);
    return 1;
  }
  for (const float r : resolutions_m) run(work, r, with_octomap);
  return 0;
}
