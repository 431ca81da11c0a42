// SPDX-License-Identifier: Apache-2.0
// The ground map and its inflation on simulated walks through the built-in buildings: time per frame, and how true they
// are. At places drawn from those that the robot can reach it turns once round; cells are then compared with the world:
//   ghosts   occupied cells with nothing solid in the body's height within 10 cm
//   missed   free cells whose middle is solid at most heights of the body
//   known    of the cells that can be seen at all, how many are known (places are few, so not all)
//   ground_bench [--resolution METRES] [--places N] [--width PX] [--world NAME]
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/camera_path.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/sim_renderer.hpp"
#include "hal/sim/world_query.hpp"
#include "mapper/mapper.hpp"
#include "nav/ground_map.hpp"
#include "nav/inflation.hpp"
#include "tests/support/sample_maps.hpp"

using namespace g3d;

namespace {

constexpr double kCamera_m = 0.5;
constexpr int kTurn_frames = 30;

double now_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

struct Options {
  float resolution_m = 0.05F;
  int places = 25;
  int width_px = 160;
  std::string world;
};

int solid_heights(const hal::World& world, double x_m, double y_m) {
  int count = 0;
  for (double z_m = 0.075; z_m < 0.6; z_m += 0.05) count += hal::is_solid(world, 0, {x_m, y_m, z_m}) ? 1 : 0;
  return count;
}

bool solid_nearby(const hal::World& world, double x_m, double y_m) {
  for (double dx = -0.1; dx <= 0.1; dx += 0.02) {
    for (double dy = -0.1; dy <= 0.1; dy += 0.02) {
      for (double z_m = 0.02; z_m < 0.62; z_m += 0.03) {
        if (hal::is_solid(world, 0, {x_m + dx, y_m + dy, z_m})) return true;
      }
    }
  }
  return false;
}

struct Truth {
  std::size_t ghosts = 0, missed = 0, drops = 0, occupied = 0, free = 0, presumed = 0;
  std::size_t known_free = 0, known_wall = 0;
};

Truth compare(const hal::World& world, const hal::Observable& observable, const nav::GroundMap& ground) {
  Truth truth;
  const auto& states = ground.states();
  for (std::size_t i = 0; i < states.cells.size(); ++i) {
    const nav::Cell c = states.cell(i);
    const double x_m = states.centre_x_m(c);
    const double y_m = states.centre_y_m(c);
    if (states.cells[i] == nav::CellState::occupied) {
      ++truth.occupied;
      truth.ghosts += solid_nearby(world, x_m, y_m) ? 0 : 1;
      truth.drops += ground.is_drop(c) ? 1 : 0;
    } else if (states.cells[i] == nav::CellState::free) {
      ++truth.free;
      truth.missed += solid_heights(world, x_m, y_m) >= 6 ? 1 : 0;
      truth.presumed += ground.is_floor_seen(c) ? 0 : 1;
    }
  }
  for (int row = 0; row < observable.frame.rows; ++row) {
    for (int column = 0; column < observable.frame.columns; ++column) {
      const hal::SeenCell seen = observable.cells[observable.frame.index(column, row)];
      if (seen == hal::SeenCell::not_observable) continue;
      const nav::Cell c = states.cell_of(observable.frame.x_m(column), observable.frame.y_m(row));
      if (!states.contains(c) || states.at(c) == nav::CellState::unknown) continue;
      ++(seen == hal::SeenCell::free ? truth.known_free : truth.known_wall);
    }
  }
  return truth;
}

void run(const std::string& name, const Options& options) {
  auto loaded = hal::load_world(name);
  if (!loaded) return fmt::print("{}: {}\n", name, loaded.error().text);
  const hal::World world = std::move(loaded).value();
  const auto starts = hal::choose_starts(world, 1, 1);
  if (!starts) return fmt::print("{}: {}\n", name, starts.error().text);
  const auto observable = hal::find_observable(world, starts.value());
  if (!observable) return fmt::print("{}: {}\n", name, observable.error().text);
  const hal::PlanFrame& frame = observable.value().frame;
  std::vector<std::size_t> reachable;
  for (std::size_t i = 0; i < observable.value().reachable.size(); ++i) {
    if (observable.value().reachable[i] != 0) reachable.push_back(i);
  }

  const float scale = static_cast<float>(options.width_px) / 640.0F;
  hal::SimRendererOptions renderer_options;
  renderer_options.camera = {options.width_px, options.width_px * 3 / 4, 525.0F * scale, 525.0F * scale,
                             319.5F * scale,   239.5F * scale,           1000.0F};
  renderer_options.threads = 2;
  hal::SimRenderer renderer(world, renderer_options);
  mapper::MapperConfig mapper_config;
  mapper_config.resolution_m = options.resolution_m;
  mapper_config.capacity = mapper::capacity_for_bytes(std::size_t{1} << 30);
  mapper::Mapper mapper(mapper_config, renderer.camera());
  nav::GroundMapConfig ground_config;
  ground_config.max_slots = mapper_config.capacity.blocks;
  nav::GroundMap ground(mapper.map().grid(), ground_config);
  nav::Inflation inflation(ground.states(), {});

  hal::Frame image = hal::make_frame(renderer.camera());
  tests::Random random(3);
  std::vector<double> ground_ms, inflation_ms, both_ms;
  std::uint64_t sequence = 0;
  for (int place = 0; place < options.places; ++place) {
    const std::size_t at = reachable[random.below(static_cast<std::uint32_t>(reachable.size()))];
    const double x_m = frame.x_m(static_cast<int>(at % static_cast<std::size_t>(frame.columns)));
    const double y_m = frame.y_m(static_cast<int>(at / static_cast<std::size_t>(frame.columns)));
    for (int i = 0; i < kTurn_frames; ++i) {
      const hal::Pose pose = hal::camera_pose({x_m, y_m, kCamera_m}, i * 360.0 / kTurn_frames, 0.0);
      renderer.render(pose, 0, sequence++, image);
      mapper.integrate(image, pose);
      const double t0 = now_ms();
      ground.update(mapper.map(), mapper.changed_slots());
      const double t1 = now_ms();
      inflation.update(ground.states(), ground.changed_cells());
      const double t2 = now_ms();
      ground_ms.push_back(t1 - t0);
      inflation_ms.push_back(t2 - t1);
      both_ms.push_back(t2 - t0);
    }
  }
  const auto quantile = [](std::vector<double>& v, double q) {
    std::sort(v.begin(), v.end());
    return v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
  };
  const Truth truth = compare(world, observable.value(), ground);
  fmt::print(
      "{:10} ground p50 {:5.2f} p99 {:5.2f}  inflation p50 {:5.2f} p99 {:5.2f}  both p99 {:5.2f} max {:5.2f} ms | {:6} "
      "free "
      "({:5} presumed, {} missed) {:6} occupied ({} ghosts, {} drops) | known {:5.1f} % of free, {:5.1f} % of walls\n",
      name, quantile(ground_ms, 0.5), quantile(ground_ms, 0.99), quantile(inflation_ms, 0.5),
      quantile(inflation_ms, 0.99), quantile(both_ms, 0.99), both_ms.back(), truth.free, truth.presumed, truth.missed,
      truth.occupied, truth.ghosts, truth.drops,
      100.0 * static_cast<double>(truth.known_free) / static_cast<double>(observable.value().free_count),
      100.0 * static_cast<double>(truth.known_wall) / static_cast<double>(observable.value().wall_count));
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::strcmp(argv[i], "--resolution") == 0) options.resolution_m = std::strtof(argv[i + 1], nullptr);
    if (std::strcmp(argv[i], "--places") == 0) options.places = std::max(1, std::atoi(argv[i + 1]));
    if (std::strcmp(argv[i], "--width") == 0) options.width_px = std::clamp(std::atoi(argv[i + 1]), 32, 640);
    if (std::strcmp(argv[i], "--world") == 0) options.world = argv[i + 1];
  }
  for (const std::string_view name : hal::exploration_names()) {
    if (options.world.empty() || options.world == name) run(std::string(name), options);
  }
  return 0;
}
