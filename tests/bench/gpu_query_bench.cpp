// SPDX-License-Identifier: Apache-2.0
// Questions to a map in a card, on a machine that has one: the CPU twin's answers bit by bit, and in how much time. The
// map is that of the simulated drive; `scripts/gpu-test` makes a bundle of it.
//   gpu_query_bench [--frames N] [--resolution METRES]... [--what rays|looks|ground|grid]... [--poses N] [--times N]
// equal: random rays, and views and looks from random poses near the drive's. time: medians over N times; wall clock
// from the question to its answer in the program's memory, of that the launches alone, and the CPU twin on one core.
// ground: the ground map from columns that the card has read, frame by frame, and from the mirror's voxels.
// grid: travel costs over 1000 x 1000 cells from random starts, an office floor and an open one; Dijkstra on one core.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "mapper/cpu/bulk_rays.hpp"
#include "mapper/cuda/ask_grid.hpp"
#include "mapper/cuda/carried.hpp"
#include "mapper/cuda/helper_process.hpp"
#include "mapper/cuda/twin.hpp"
#include "mapper/mapper.hpp"
#include "nav/distance_field.hpp"
#include "nav/ground_map.hpp"
#include "nav/inflation.hpp"
#include "tests/support/bulk_rays.hpp"
#include "tests/support/floor_plans.hpp"
#include "tests/support/workload.hpp"

using namespace g3d;
using namespace g3d::mapper;

namespace {

constexpr int kGridSide = 1000;
int failures = 0;

double now_us() { return static_cast<double>(hal::RealClock().now()) * 1e-3; }

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A drive's map in a card, its mirror and the CPU twin.
struct Rig {
  Rig(const MapperConfig& settings, const test::Workload& work)
      : config(settings),
        sensor(work.camera, settings.resolution_m, settings.near_m, settings.far_m),
        map(Grid{settings.resolution_m}, settings.capacity),
        twin(settings, sensor, {}, map),
        counter(sensor) {
    std::string problem;
    cuda::MemorySizes sizes = twin.builder().sizes();
    sizes.grid_cells = kGridSide * kGridSide;
    helper = cuda::HelperProcess::start({.program = cuda::carried_helper(),
                                         .kernels = cuda::carried_kernels(),
                                         .sizes = sizes,
                                         .column_slope = sensor.column_slope,
                                         .row_slope = sensor.row_slope,
                                         .mask = twin.builder().mask(),
                                         .patience_ns = 60'000'000'000},
                                        problem);
    if (helper != nullptr && helper->wait_started(60'000'000'000) == cuda::HelperState::ready) twin.set_card(helper);
    if (!twin.has_card()) {
      fmt::print("no card: {}\n", helper != nullptr ? helper->problem() : problem);
      ++failures;
      return;
    }
    for (const auto& [frame, pose] : work.frames) poses.push_back(pose);
  }
  void begin(const test::PosedImage& image) {
    const auto geometry = cpu::frame_geometry(sensor, hal::to_transform(image.T_world_camera));
    check(geometry && twin.begin(image.frame, *geometry, image.frame.has_colour, ++frame_number, report));
  }
  void integrate(const test::PosedImage& image) {
    begin(image);
    check(twin.finish(report));
  }
  [[nodiscard]] double card_us() const { return static_cast<double>(helper->stages_us()[0]); }
  void check(bool answered) {
    if (answered) return;
    fmt::print("the card failed: {}\n", helper->problem());
    ++failures;
  }

  MapperConfig config;
  cpu::SensorGeometry sensor;
  VoxelMap map;
  cuda::Twin twin;
  cpu::LookCounter counter;
  cpu::ThreadPool one_core{1};
  std::shared_ptr<cuda::HelperProcess> helper;
  std::vector<hal::Pose> poses;
  FrameReport report;
  std::uint32_t frame_number = 0;
};

/// Near a pose of the drive, turned a little.
hal::RigidTransform near_pose(const Rig& rig, tests::Random& random) {
  hal::Pose pose = rig.poses[random.below(static_cast<std::uint32_t>(rig.poses.size()))];
  for (double& x : pose.translation_m) x += random.uniform(-0.3, 0.3);
  hal::RigidTransform T = hal::to_transform(pose);
  const double angle_rad = random.uniform(-3.14, 3.14);  // about the world's z
  const auto c = static_cast<float>(std::cos(angle_rad));
  const auto s = static_cast<float>(std::sin(angle_rad));
  for (std::size_t column = 0; column < 3; ++column) {
    const float x = T.rotation[column];
    const float y = T.rotation[3 + column];
    T.rotation[column] = c * x - s * y;
    T.rotation[3 + column] = s * x + c * y;
  }
  return T;
}

void print_equal(const Rig& rig, const char* what, std::size_t asked, std::size_t different) {
  failures += different == 0 ? 0 : 1;
  fmt::print("equal   {} {:.3f} m: {} asked, {} different by {} {}\n", what, rig.config.resolution_m, asked, different,
             rig.helper->card_name(), different == 0 ? "ok" : "FAILED");
  std::fflush(stdout);
}

std::size_t count_different(Rig& rig, const std::vector<BulkRay>& rays, std::array<std::size_t, 4>& ends) {
  std::vector<BulkHit> hits(rays.size());
  std::vector<BulkHit> expected(rays.size());
  rig.check(rig.twin.cast_rays(rays, hits));
  cpu::cast_bulk_rays(rig.map, rays, expected, rig.one_core);
  std::size_t different = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    different += std::memcmp(&hits[i], &expected[i], sizeof(BulkHit)) == 0 ? 0 : 1;
    ++ends[static_cast<std::size_t>(expected[i].end)];
  }
  return different;
}

void rays_equal(Rig& rig, int poses) {
  tests::Random random(11);
  std::array<std::size_t, 4> ends{};
  const std::size_t wild = 100'000;
  std::size_t asked = wild;
  std::size_t different = count_different(rig, test::random_rays(12, wild, rig.config.resolution_m, 4.0), ends);
  for (int i = 0; i < poses; ++i) {
    std::vector<BulkRay> rays(rig.sensor.camera.pixel_count());
    rays.resize(cpu::rays_from(rig.sensor, near_pose(rig, random), 4, rays));
    for (BulkRay& ray : rays) ray.stop_at_unknown = i % 2 == 0 ? 1 : 0;
    asked += rays.size();
    different += count_different(rig, rays, ends);
  }
  print_equal(rig, "rays", asked, different);
  fmt::print("        they end: {} occupied, {} unknown, {} at their range, {} out of the grid\n", ends[0], ends[1],
             ends[2], ends[3]);
}

void rays_time(Rig& rig, int times) {
  for (const std::size_t count : {std::size_t{1000}, std::size_t{10'000}, std::size_t{100'000}, std::size_t{307'200}}) {
    tests::Random random(21);
    std::vector<double> wall_us;
    std::vector<double> card_us;
    std::vector<double> cpu_us;
    double length_m = 0.0;
    for (int i = 0; i < times; ++i) {
      std::vector<BulkRay> rays(rig.sensor.camera.pixel_count());
      const int stride_px = count > 200'000 ? 1 : count > 50'000 ? 1 : count > 5'000 ? 5 : 16;
      rays.resize(std::min(count, cpu::rays_from(rig.sensor, near_pose(rig, random), stride_px, rays)));
      while (rays.size() < count) rays.push_back(rays[rays.size() / 2]);
      std::vector<BulkHit> hits(rays.size());
      const double start_us = now_us();
      rig.check(rig.twin.cast_rays(rays, hits));
      const double half_us = now_us();
      wall_us.push_back(half_us - start_us);
      card_us.push_back(rig.card_us());
      for (const BulkHit& hit : hits) length_m += static_cast<double>(hit.distance_m) / static_cast<double>(count);
      if (i >= 7) continue;  // the CPU twin is slow
      const double cpu_start_us = now_us();
      cpu::cast_bulk_rays(rig.map, rays, hits, rig.one_core);
      cpu_us.push_back(now_us() - cpu_start_us);
    }
    fmt::print("time    {:6} rays {:.3f} m: {:.0f} us, launch alone {:.0f} us, CPU twin {:.0f} us, {:.2f} m each\n",
               count, rig.config.resolution_m, median(wall_us), median(card_us), median(cpu_us), length_m / times);
    std::fflush(stdout);
  }
}

std::vector<Look> some_looks(const Rig& rig, tests::Random& random, std::size_t count) {
  std::vector<Look> looks;
  while (looks.size() < count) looks.push_back(cpu::look_from(rig.sensor, near_pose(rig, random)));
  return looks;
}

void looks_equal(Rig& rig, int poses) {
  tests::Random random(31);
  std::size_t different = 0;
  std::uint64_t unknown = 0;
  const LookModel model = cpu::look_model(rig.sensor, 4);
  std::vector<Look> looks = some_looks(rig, random, static_cast<std::size_t>(poses));
  std::vector<Look> expected = looks;
  rig.check(rig.twin.count_looks(model, looks));
  rig.counter.count(rig.map, model, expected, rig.one_core);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    different += std::memcmp(&looks[i], &expected[i], sizeof(Look)) == 0 ? 0 : 1;
    unknown += expected[i].gain.unknown_voxels;
  }
  print_equal(rig, "looks", looks.size(), different);
  fmt::print("        {} unknown voxels seen by each\n", unknown / looks.size());
}

void looks_time(Rig& rig, int times) {
  for (const int stride_px : {4, 8}) {
    const LookModel model = cpu::look_model(rig.sensor, stride_px);
    for (const std::size_t count : {std::size_t{1}, std::size_t{16}, std::size_t{128}}) {
      tests::Random random(41);
      std::vector<double> wall_us;
      std::vector<double> card_us;
      std::vector<double> cpu_us;
      for (int i = 0; i < times; ++i) {
        std::vector<Look> looks = some_looks(rig, random, count);
        std::vector<Look> again = looks;
        const double start_us = now_us();
        rig.check(rig.twin.count_looks(model, looks));
        const double half_us = now_us();
        wall_us.push_back(half_us - start_us);
        card_us.push_back(rig.card_us());
        if (i >= (count > 16 ? 1 : 3)) continue;  // the CPU twin is slow
        const double cpu_start_us = now_us();
        rig.counter.count(rig.map, model, again, rig.one_core);
        cpu_us.push_back(now_us() - cpu_start_us);
      }
      fmt::print(
          "time    {:3} looks {:.3f} m, every {} px: {:.0f} us, launches of the last round alone {:.0f} us ({} looks "
          "in a round), CPU twin {:.0f} us\n",
          count, rig.config.resolution_m, stride_px, median(wall_us), median(card_us), rig.helper->look_room(),
          median(cpu_us));
      std::fflush(stdout);
    }
  }
}

void ground(const MapperConfig& config, const test::Workload& work) {
  Rig rig(config, work);
  if (!rig.twin.has_card()) return;
  nav::GroundMapConfig ground_config;
  ground_config.max_slots = config.capacity.blocks;
  nav::GroundMap from_card(rig.map.grid(), ground_config);
  nav::GroundMap from_voxels(rig.map.grid(), ground_config);
  rig.twin.follow_columns(from_card.column_tables());
  std::vector<double> read_us;
  std::vector<double> card_us;
  std::vector<double> told_us;
  std::vector<double> voxels_us;
  std::vector<double> changed;
  std::size_t different = 0;
  for (const test::PosedImage& image : work.frames) {
    rig.begin(image);
    const double start_us = now_us();
    rig.check(rig.helper->read_columns(0));  // once more, alone
    read_us.push_back(now_us() - start_us);
    card_us.push_back(rig.card_us());
    const double told_start_us = now_us();
    from_card.update(rig.twin.changed_columns());
    told_us.push_back(now_us() - told_start_us);
    rig.check(rig.twin.finish(rig.report));
    from_card.note_slots(rig.map, rig.twin.changed_slots());
    const double voxels_start_us = now_us();
    from_voxels.update(rig.map, rig.twin.changed_slots());
    voxels_us.push_back(now_us() - voxels_start_us);
    changed.push_back(static_cast<double>(rig.twin.changed_slots().size()));
    different += from_card.states().cells == from_voxels.states().cells ? 0 : 1;
  }
  print_equal(rig, "ground maps", work.frames.size(), different);
  fmt::print(
      "time    ground map {:.3f} m, {:.0f} changed blocks: columns read in {:.0f} us, launch alone {:.0f} us, taken "
      "over "
      "in {:.0f} us; from the mirror's voxels {:.0f} us\n",
      config.resolution_m, median(changed), median(read_us), median(card_us), median(told_us), median(voxels_us));
  std::fflush(stdout);
}

void grid(Rig& rig, int times) {
  nav::CellGrid<std::uint8_t> open(0.05, 0.0, 0.0, kGridSide, kGridSide, nav::kFreeCost);
  const nav::CellGrid<nav::CellState> office = tests::office_floor(2, kGridSide);
  nav::Inflation inflation(office, {});
  inflation.rebuild(office);
  for (const bool is_open : {false, true}) {
    const nav::CellGrid<std::uint8_t>& cost = is_open ? open : inflation.cost();
    nav::DistanceField field(cost.cells.size());
    tests::Random random(51);
    std::vector<double> wall_us;
    std::vector<double> card_us;
    std::vector<double> cpu_us;
    std::vector<double> reached;
    std::size_t different = 0;
    std::vector<std::uint32_t> distances(cost.cells.size());
    const auto cells = static_cast<std::uint32_t>(cost.cells.size());
    for (int i = 0; i < times; ++i) {
      nav::Cell start = cost.cell(random.below(cells));
      while (cost.at(start) != nav::kFreeCost) start = cost.cell(random.below(cells));
      const double start_us = now_us();
      rig.check(cuda::ask_grid(*rig.helper, nav::spread_of(cost, start), cost.cells, distances));
      const double half_us = now_us();
      field.compute(cost, start);
      cpu_us.push_back(now_us() - half_us);
      wall_us.push_back(half_us - start_us);
      card_us.push_back(rig.card_us());
      reached.push_back(static_cast<double>(field.reached().size()));
      for (std::uint32_t c = 0; c < cells; ++c) different += distances[c] != field.cost_to(c) ? 1 : 0;
    }
    print_equal(rig, is_open ? "cells of an open floor" : "cells of an office", cost.cells.size() * reached.size(),
                different);
    fmt::print("time    travel costs of {:.0f} cells: {:.0f} us, launches {:.0f} us, Dijkstra {:.0f} us\n",
               median(reached), median(wall_us), median(card_us), median(cpu_us));
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  int frames = 60;
  int poses = 100;
  int times = 21;
  std::vector<float> resolutions_m;
  std::vector<std::string> what;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    const std::string value = argv[i + 1];
    if (name == "--frames") frames = std::atoi(value.c_str());
    if (name == "--poses") poses = std::atoi(value.c_str());
    if (name == "--times") times = std::atoi(value.c_str());
    if (name == "--what") what.push_back(value);
    if (name == "--resolution") resolutions_m.push_back(static_cast<float>(std::atof(value.c_str())));
  }
  if (resolutions_m.empty()) resolutions_m = {0.05F, 0.02F, 0.01F};
  if (what.empty()) what = {"rays", "looks", "ground", "grid"};
  const test::Workload work = test::simulated_drive("furnished_room", frames, 60.0 / frames);
  if (work.frames.empty() || poses < 1 || times < 1) {
    fmt::print(stderr, "gpu_query_bench: no frames, poses or times\n");
    return 1;
  }
  for (const float resolution_m : resolutions_m) {
    MapperConfig config;
    config.resolution_m = resolution_m;
    config.capacity = capacity_for_bytes(std::size_t{1024} << 20);
    Rig rig(config, work);
    if (!rig.twin.has_card()) break;
    for (const test::PosedImage& image : work.frames) rig.integrate(image);
    for (const std::string& one : what) {
      if (one == "rays") {
        rays_equal(rig, poses);
        rays_time(rig, times);
      }
      if (one == "looks") {
        looks_equal(rig, poses);
        looks_time(rig, times);
      }
      if (one == "ground") ground(config, work);
      if (one == "grid" && resolution_m == resolutions_m.front()) grid(rig, times);
    }
  }
  fmt::print("{} failures\n", failures);
  return failures == 0 ? 0 : 1;
}
