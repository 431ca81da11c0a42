// SPDX-License-Identifier: Apache-2.0
// How much faster than time a simulated building runs, at 160 x 120 pixels and 10 Hz with a map of 5 cm: a robot drives
// a fixed programme for a minute in each of our worlds. With --truth it is put on poses all over the floor instead, and
// looks all round: then what the map knows must be what find_observable() says can be known.
//   building_bench [--truth] [WORLD ...]
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "hal/frame_pool.hpp"
#include "hal/kobuki/command.hpp"
#include "hal/sim/builtin_worlds.hpp"
#include "hal/sim/load_world.hpp"
#include "hal/sim/observable.hpp"
#include "hal/sim/sim_building.hpp"
#include "mapper/mapper.hpp"
#include "nav/coverage.hpp"
#include "nav/ground_map.hpp"

using namespace g3d;

namespace {

constexpr hal::TimeNs kFramePeriod_ns = 100'000'000;
constexpr int kFrames = 600;
constexpr int kLattice_cells = 12;
constexpr int kHeadings = 9;

/// Of processor time, on all threads together: what else the machine does must not count.
double seconds_of(const auto& work) {
  const auto cpu_s = [] {
    timespec t{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) / 1e9;
  };
  const double begin_s = cpu_s();
  work();
  return cpu_s() - begin_s;
}

void drive(hal::ByteLine& line, int frame) {
  const bool ahead = frame % 100 < 60;
  std::array<std::uint8_t, hal::kobuki::kMaxCommand_bytes> bytes;
  const std::size_t n = hal::kobuki::encode_base_control({ahead ? 0.3 : 0.0, ahead ? 0.1 : 1.0}, bytes);
  (void)line.write(std::span(bytes).first(n));
}

void measure_speed(const std::string& name, const hal::World& world, const hal::PlanarPose& start) {
  hal::SimBuildingOptions options;
  options.camera = hal::scaled_kinect(160, 120);
  options.robots.emplace_back().T_world_base = start;
  hal::SimBuilding building(world, options);
  hal::Frame frame = hal::make_frame(building.camera());
  mapper::Mapper mapper({}, building.camera());
  std::array<std::uint8_t, 4096> bytes;
  double move_s = 0.0;
  double draw_s = 0.0;
  double map_s = 0.0;
  for (int i = 0; i < kFrames; ++i) {
    drive(building.line(0), i);
    move_s += seconds_of([&] {
      building.advance_to((i + 1) * kFramePeriod_ns);
      (void)building.line(0).read(bytes);
    });
    draw_s += seconds_of([&] { building.render(0, frame); });
    map_s += seconds_of([&] { mapper.integrate(frame, building.T_world_camera(0)); });
  }
  const auto ms = [](double s) { return s / kFrames * 1e3; };
  fmt::print("{:14} {:4} solids: move {:.3f}, draw {:.3f}, map {:.3f} ms of one core per frame: {:.0f} x real time\n",
             name, world.primitives().size(), ms(move_s), ms(draw_s), ms(map_s),
             kFrames * kFramePeriod_ns / 1e9 / (move_s + draw_s + map_s));
}

void measure_truth(const std::string& name, const hal::World& world, const hal::PlanarPose& start) {
  const auto found = hal::find_observable(world, std::span(&start, 1));
  if (!found) return fmt::print("{}: {}\n", name, found.error().text);
  const hal::Observable& truth = found.value();
  hal::SimRendererOptions options;
  options.camera = hal::scaled_kinect(160, 120);
  hal::SimRenderer renderer(world, options);
  hal::Frame frame = hal::make_frame(options.camera);
  mapper::Mapper mapper({}, options.camera);
  nav::GroundMapConfig ground_config;
  ground_config.centre_x_m = start.x_m;
  ground_config.centre_y_m = start.y_m;
  nav::GroundMap ground(mapper.map().grid(), ground_config);
  const std::vector<std::array<float, 2>> nobody(world.movers().size(), {5000.0F, 5000.0F});
  std::uint64_t frames = 0;
  for (int row = 0; row < truth.frame.rows; row += kLattice_cells) {
    for (int column = 0; column < truth.frame.columns; column += kLattice_cells) {
      if (truth.reachable[truth.frame.index(column, row)] == 0) continue;
      for (int k = 0; k < kHeadings; ++k) {
        const hal::PlanarPose pose{truth.frame.x_m(column), truth.frame.y_m(row), 2 * std::numbers::pi * k / kHeadings};
        const hal::Pose eye = hal::compose(hal::pose_on_floor(pose), hal::forward_camera());
        renderer.render(eye, 0, frames++, nobody, -1, frame);
        mapper.integrate(frame, eye);
        ground.update(mapper.map(), mapper.changed_slots());
      }
    }
  }
  const double known = nav::CoverageMeter(truth).fraction(ground.states());
  fmt::print("{:14} {:6} frames, {} free and {} wall cells observable: {:.2f} % of them known\n", name, frames,
             truth.free_count, truth.wall_count, 100.0 * known);
}

}  // namespace

int main(int argc, char** argv) {
  bool truth = false;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--truth") {
      truth = true;
    } else {
      names.push_back(word);
    }
  }
  if (names.empty()) names.assign(hal::exploration_names().begin(), hal::exploration_names().end());
  for (const std::string& name : names) {
    const auto world = hal::load_world(name);
    if (!world) {
      fmt::print(stderr, "{}\n", world.error().text);
      return 1;
    }
    const auto starts = hal::choose_starts(world.value(), 1, 1);
    if (!starts) {
      fmt::print(stderr, "{}\n", starts.error().text);
      return 1;
    }
    if (truth) {
      measure_truth(name, world.value(), starts.value()[0]);
    } else {
      measure_speed(name, world.value(), starts.value()[0]);
    }
  }
  return 0;
}
